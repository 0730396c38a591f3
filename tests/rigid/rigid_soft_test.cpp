// Rigid bodies that meet reduced ones.
#include <cmath>
#include <string>

#include "tests/rigid/rigid_scene.h"
#include "tests/support/frames/frame_models.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::kG;
using testing::rigid_body;

constexpr double kLength = 1.0;  // of the beam, along x, m

// A beam clamped at x = -1/2 whose centre line bends as a polynomial of s = x + 1/2, in one
// coordinate for each of s^2 ... s^5; or without a support. Linear: its compliance is U Lambda^-1
// U^T everywhere.
Model::Pointer beam(bool free) {
  testing::PointCloud cloud;
  constexpr int kCells = 20;
  for (int i = 0; i <= kCells; ++i)
    for (const double y : {-0.05, 0.0, 0.05})
      for (const double z : {-0.025, 0.025}) {
        cloud.places.emplace_back(kLength * i / kCells - 0.5 * kLength, y, z);
        cloud.masses.push_back(0.05);
      }
  const auto n = static_cast<Eigen::Index>(cloud.places.size());
  Eigen::MatrixXd fields(3 * n, 4);
  fields.setZero();
  for (Eigen::Index k = 0; k < n; ++k)
    for (int power = 2; power < 6; ++power) {
      const double x = cloud.places[static_cast<std::size_t>(k)].x() / kLength + 0.5;
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
  body.contact.shape = BoxShape{{0.5 * kLength, 0.05, 0.025}};
  return body;
}

Result<Model::Pointer> beam_of(const SceneBody& body) {
  return beam(body.model == "free");
}

// A ball that rests on a beam bends it by the compliance at its place times its weight.
TEST(RigidOnSoft, BendsABeamByItsWeight) {
  for (const double step : {3e-3, 1.5e-3, 0.75e-3}) {
    Scene scene;
    scene.step = step;
    scene.gravity.values = {{0.0, 0.0, -kG}};
    SceneBody soft = beam_body(false);
    soft.options.alpha = 40.0;
    // Without a shape the beam feels by its vertices alone: the ball rests on one of them.
    soft.contact.shape.reset();
    soft.contact.restitution = 0.0;
    const SceneBody ball = rigid_body("ball", SphereShape{0.04}, {0.3, 0.0, 0.065}, 8000.0);
    scene.bodies = {soft, ball};
    // Four walls without friction, a fifth of a millimetre away, keep it on the vertex.
    for (const Vector3d& side : {Vector3d(1.0, 0.0, 0.0), Vector3d(-1.0, 0.0, 0.0),
                                 Vector3d(0.0, 1.0, 0.0), Vector3d(0.0, -1.0, 0.0)}) {
      SceneCollider wall;
      wall.name = "wall-" + std::to_string(scene.colliders.size());
      wall.shape = BoxShape{{0.05, 0.05, 0.2}};
      wall.pose.position = Vector3d(0.3, 0.0, 0.24) + (0.05 + 0.04 + 2e-4) * side;
      wall.friction = 0.0;
      wall.restitution = 0.0;
      scene.colliders.push_back(wall);
    }
    SceneWorld world = testing::make_world(scene, beam_of);
    testing::run_until(world, 2.0);
    const double weight = kG * world.body(1).model().inertia()->mass;
    const double pushed = world.body(1).contact_account().impulse_vector.z() / step;
    EXPECT_NEAR(pushed, weight, 1e-3 * weight);
    const Model& model = world.body(0).model();
    const Result<VertexRows> place = model.vertex(6 * 16 + 3);  // s = 0.8, y = 0, upper side
    ASSERT_TRUE(place);
    ASSERT_NEAR((place->rest - Vector3d(0.3, 0.0, 0.025)).norm(), 0.0, 1e-12);
    const auto bent_by = [&](const Eigen::VectorXd& force) {
      return (place->rows * model.lambda().cwiseInverse().cwiseProduct(force)).z();
    };
    const double own = bent_by(model.inertia_about_origin()->s.transpose() * Vector3d(0, 0, -kG));
    const double expected = bent_by(place->rows.transpose() * Vector3d(0.0, 0.0, -weight));
    const double found = (place->rows * world.body(0).state().q).z() - own;
    EXPECT_LT(expected, -1e-3);
    EXPECT_NEAR(found / expected, 1.0, 1e-3) << step;
  }
}

// Whether a body begins inside another one is seen at the shape in which that one begins.
TEST(RigidOnSoft, ABlockIsLaidOnABeamThatBeginsSagged) {
  SceneBody soft = beam_body(false);
  soft.settled = true;
  Scene scene;
  scene.gravity.values = {{0.0, 0.0, -kG}};
  scene.bodies = {soft};
  const SceneWorld alone = testing::make_world(scene, beam_of);
  const Result<VertexRows> place = alone.body(0).model().vertex(6 * 16 + 3);  // of the upper side
  ASSERT_TRUE(place);
  const double upper = (place->rest + place->rows * alone.body(0).state().q).z();
  ASSERT_LT(upper, 0.025 - 2e-3);  // it sags by more than the block's margin
  const auto begins = [&](double above) {
    Scene laid = scene;
    laid.bodies.push_back(
        rigid_body("block", BoxShape{{0.02, 0.02, 0.01}}, {0.3, 0.0, upper + 0.01 + above}));
    return SceneWorld::create(laid, beam_of);
  };
  EXPECT_TRUE(begins(1e-3));
  const Result<SceneWorld> inside = begins(-4e-3);
  ASSERT_FALSE(inside);
  EXPECT_NE(inside.error().message.find("inside body 'beam'"), std::string::npos)
      << inside.error().message;
}

// A ball hits a free beam off its centre, from above.
TEST(RigidOnSoft, KeepsBothMomentaOfABlow) {
  for (const double step : {3e-3, 1.5e-3, 0.75e-3})
    for (const bool shaped : {true, false}) {
      Scene scene;
      scene.step = step;
      SceneBody soft = beam_body(true);
      if (!shaped) soft.contact.shape.reset();
      SceneBody ball = rigid_body("ball", SphereShape{0.08}, {0.22, 0.01, 0.2}, 1000.0);
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

// A blow beside a shaken beam divides the step of the beam too: between two parts its frame is on
// its way, and the forces of its motion are those of the whole step.
TEST(RigidOnSoft, AShakenBeamTakesTheStepInParts) {
  constexpr double kE = 0.5, kV = 2.0;
  const auto run = [&](double step, bool balls, const auto& look) {
    Scene scene;
    scene.step = step;
    SceneBody shaken = beam_body(false);
    shaken.kind = FrameKind::kDriven;
    shaken.motion.parts = {
        ShakeMotion{{0.0, 0.0, 0.002}, 8.0, {.start = 0.0, .end = 10.0, .ramp = 0.05}},
        SwingMotion{{0.0, 0.0, 1.0},
                    Vector3d::Zero(),
                    0.2,
                    4.0,
                    0.0,
                    {.start = 0.0, .end = 10.0, .ramp = 0.05}}};
    scene.bodies = {shaken};
    for (int k = 0; balls && k < 2; ++k) {
      scene.bodies.push_back(rigid_body("ball-" + std::to_string(k), SphereShape{0.03},
                                        {0.05 + 0.16 * k, 0.0, 0.068}));
      scene.bodies.back().contact.restitution = kE;
    }
    if (balls) scene.bodies[1].velocity.x() = kV;
    SceneWorld world = testing::make_world(scene, beam_of);
    testing::run_until(world, 0.12, [&] { look(world); });
    return world;
  };
  const auto none = [](const SceneWorld&) {};
  testing::Growth growth;
  const SceneWorld parts = run(3e-3, true, [&](SceneWorld& world) { growth.look(world); });
  EXPECT_EQ(parts.contacts(0), 0);
  EXPECT_NEAR(parts.body(2).rigid_state().velocity.x() - parts.body(1).rigid_state().velocity.x(),
              kE * kV, 0.01 * kV);
  EXPECT_LT(growth.worst, 1e-9 * growth.most);
  const Eigen::VectorXd exact = run(3e-3 / 16, false, none).body(0).state().q;
  const Eigen::VectorXd whole = run(3e-3, false, none).body(0).state().q;
  RecordProperty("whole", ::testing::PrintToString((whole - exact).norm() / exact.norm()));
  RecordProperty("parts",
                 ::testing::PrintToString((parts.body(0).state().q - exact).norm() / exact.norm()));
  EXPECT_LT((parts.body(0).state().q - exact).norm(), 0.03 * exact.norm());
}

}  // namespace
}  // namespace tremolo
