// Rigid bodies that meet reduced ones.
#include <cmath>
#include <vector>

#include "tests/rigid/rigid_scene.h"
#include "tests/support/frames/frame_models.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::kG;
using testing::rigid_body;

constexpr double kLength = 1.0;  // of the beam, along x, m

// A beam clamped at x = 0 whose centre line bends as a polynomial of x, in one coordinate for each
// of x^2 ... x^5; or without a support. Linear: its compliance is U Lambda^-1 U^T everywhere.
Model::Pointer beam(bool free) {
  testing::PointCloud cloud;
  constexpr int kCells = 20;
  for (int i = 0; i <= kCells; ++i)
    for (const double y : {-0.05, 0.0, 0.05})
      for (const double z : {-0.025, 0.025}) {
        cloud.places.emplace_back(kLength * i / kCells, y, z);
        cloud.masses.push_back(0.05);
      }
  const auto n = static_cast<Eigen::Index>(cloud.places.size());
  Eigen::MatrixXd fields(3 * n, 4);
  fields.setZero();
  for (Eigen::Index k = 0; k < n; ++k)
    for (int power = 2; power < 6; ++power) {
      const double x = cloud.places[static_cast<std::size_t>(k)].x() / kLength;
      const double z = cloud.places[static_cast<std::size_t>(k)].z();
      fields(3 * k + 2, power - 2) = std::pow(x, power);
      fields(3 * k, power - 2) = -z * power * std::pow(x, power - 1) / kLength;
    }
  if (free) {
    Eigen::MatrixXd all(3 * n, 10);
    all << testing::rigid_fields(cloud), fields;
    cloud.basis = testing::mass_orthonormal(std::move(all), cloud.masses).rightCols(4);
  } else {
    cloud.basis = testing::mass_orthonormal(std::move(fields), cloud.masses);
  }
  BasisData data;
  data.vertex_count = static_cast<std::uint64_t>(n);
  data.tetrahedron_count = 1;
  data.linear_mode_count = 4;
  data.rigid_mode_count = free ? 6 : 0;
  data.lambda = Eigen::Vector4d(40.0, 200.0, 600.0, 1200.0).cwiseAbs2();
  for (Eigen::Index k = 0; k < n; ++k) data.surface.vertex_ids.push_back(static_cast<VertexId>(k));
  data.surface.rest = cloud.places;
  data.surface.rows = cloud.basis;
  data.interior.rows.resize(0, 4);
  const auto at = [](int i, int y, int z) { return static_cast<VertexId>(6 * i + 2 * y + z); };
  for (int i = 0; i < kCells; ++i)
    for (int y = 0; y < 2; ++y)
      for (int z = 0; z < 2; ++z) {
        data.triangles.push_back({at(i, y, z), at(i + 1, y, z), at(i + 1, y + 1, z)});
        data.triangles.push_back({at(i, y, z), at(i + 1, y + 1, z), at(i, y + 1, z)});
      }
  data.inertia = testing::integrals_of(cloud);
  data.total_mass = data.inertia->mass;
  data.provenance = "{}";
  Result<Model::Pointer> model = Model::from_data(data, {.linear = true});
  EXPECT_TRUE(model) << (model ? "" : model.error().message);
  return *model;
}

SceneBody beam_body(bool free) {
  SceneBody body;
  body.name = "beam";
  body.model = free ? "free" : "clamped";
  body.kind = free ? FrameKind::kFree : FrameKind::kFixed;
  body.contact.shape = BoxShape{{kLength, 0.05, 0.025}};
  return body;
}

Result<Model::Pointer> beam_of(const SceneBody& body) {
  return beam(body.model == "free");
}

// A ball that rests on a beam bends it by the compliance times its weight.
TEST(RigidOnSoft, BendsABeamByItsWeight) {
  Scene scene;
  scene.step = 1.5e-3;
  scene.gravity.values = {{0.0, 0.0, -kG}};
  SceneBody soft = beam_body(false);
  soft.options.alpha = 20.0;
  // A box lies flat on the beam near its end and does not roll off.
  SceneBody ball = rigid_body("ball", SphereShape{0.04}, {0.8, 0.0, 0.065}, 2000.0);
  ball.contact.friction = 1.0;
  scene.bodies = {soft, ball};
  // Held at its place along the beam by weak guides: hands that act sideways do not exist, so a
  // slope of the beam is avoided by the symmetry of a groove: two colliders without friction.
  for (const double side : {-1.0, 1.0}) {
    SceneCollider guide;
    guide.name = side < 0.0 ? "left" : "right";
    guide.shape = BoxShape{{0.05, 0.2, 0.2}};
    guide.pose.position = {0.8 + side * (0.05 + 0.04 + 2e-4), 0.0, 0.24};
    guide.friction = 0.0;
    guide.restitution = 0.0;
    scene.colliders.push_back(guide);
  }
  scene.bodies[0].feels_contact = true;
  SceneWorld world = testing::make_world(scene, beam_of);
  testing::run_until(world, 4.0);
  // The beam's own weight bends it too: the static shape of all forces, at the vertices where they
  // act, and of gravity.
  const ContactBody& own = world.body(0);
  const Model& model = own.model();
  const Vector3d ball_force = world.body(1).contact_account().impulse_vector / scene.step;
  const double mass = world.body(1).model().inertia()->mass;
  EXPECT_NEAR(ball_force.z(), mass * kG, 1e-3 * mass * kG);
  const Vector3d on_beam = own.contact_account().impulse_vector / scene.step;
  EXPECT_NEAR(on_beam.z(), -mass * kG, 1e-3 * mass * kG);
  // The deflection at the ball, against the compliance there.
  const Result<VertexRows> place = model.vertex(6 * 16 + 3);  // x = 0.8, y = 0, upper side
  ASSERT_TRUE(place);
  EXPECT_NEAR(place->rest.x(), 0.8, 1e-12);
  const Eigen::VectorXd inverse = model.lambda().cwiseInverse();
  const Eigen::VectorXd gravity = model.inertia_about_origin()->s.transpose() * Vector3d(0, 0, -kG);
  const Eigen::VectorXd q =
      inverse.cwiseProduct(gravity + place->rows.transpose() * Vector3d(0.0, 0.0, -mass * kG));
  const double expected = (place->rows * q).z(), found = (place->rows * own.state().q).z();
  EXPECT_LT(expected, -1e-3);
  EXPECT_NEAR(found, expected, 1e-3 * std::abs(expected));
}

// A ball hits a free beam off its centre, from above.
TEST(RigidOnSoft, KeepsBothMomentaOfABlow) {
  for (const double step : {3e-3, 1.5e-3, 0.75e-3})
    for (const bool shaped : {true, false}) {
      Scene scene;
      scene.step = step;
      SceneBody soft = beam_body(true);
      if (!shaped) soft.contact.shape.reset();
      if (shaped) soft.contact.shape = BoxShape{{kLength, 0.05, 0.025}};
      SceneBody ball = rigid_body("ball", SphereShape{0.08}, {0.72, 0.01, 0.2}, 1000.0);
      ball.velocity = {0.3, 0.0, -2.0};
      ball.spin = {0.0, 5.0, 1.0};
      scene.bodies = {soft, ball};
      SceneWorld world = testing::make_world(scene, beam_of);
      const auto sum = [&world] {
        return Momenta{world.momenta(0).linear + world.momenta(1).linear,
                       world.momenta(0).angular + world.momenta(1).angular};
      };
      const Momenta before = sum();
      testing::Growth growth;
      testing::run_until(world, 0.3, [&] { growth.look(world); });
      EXPECT_GT(world.contacts(1), 0);
      EXPECT_LT((sum().linear - before.linear).norm(), 1e-10 * before.linear.norm());
      EXPECT_LT((sum().angular - before.angular).norm(), 1e-10 * before.angular.norm());
      EXPECT_LT(growth.worst, 1e-6 * growth.most);
    }
}

}  // namespace
}  // namespace tremolo
