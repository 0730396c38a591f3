// Known answers of contact with bodies of tetrahedra: weights, slopes, bars that exchange their
// motion.
#include <algorithm>
#include <cmath>

#include "tests/mixed/mixed_bodies.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::MixedKind;
using testing::MixedWorld;

constexpr double kGravity = 9.81;

PlacedCollider plane(double friction, double restitution = 0.5) {
  PlacedCollider floor;
  floor.shape = PlaneShape{};
  floor.friction = friction;
  floor.restitution = restitution;
  return floor;
}

// A soft cube of tetrahedra on a reduced cube on the floor, each of 1 kg.
TEST(MixedStack, CarriesItsWeight) {
  const MixedKind kind{.restitution = 0.0,
                       .friction = 0.5,
                       .gravity = {0, 0, -kGravity},
                       .method = TetMethod::kImplicitEuler,
                       .beta = 5e-3};
  MixedWorld world(kind.step);
  ContactBody lower = testing::reduced_body(testing::reduced_cube("1e5"), kind, {0, 0, 0.0503});
  ASSERT_TRUE(lower.set_damping(30.0, 5e-3));
  ASSERT_TRUE(world.add("lower", std::move(lower)));
  ASSERT_TRUE(world.add("upper",
                        testing::tets_body(testing::tets_cube(3e4, 2), kind, {0, 0, 0.1506},
                                           Vector3d::Zero(), Vector3d::Zero()),
                        testing::contact_of(kind, Eigen::Vector3d::Ones())));
  const PlacedCollider floor = plane(0.5);
  world.set_colliders({&floor, 1});
  for (int i = 0; i < 500; ++i) {
    const Status made = world.step();
    ASSERT_TRUE(made) << i << made.error().message;
  }
  const Vector3d on_upper = world.account(1).impulse_vector / kind.step;
  const Vector3d on_lower = world.account(0).impulse_vector / kind.step;
  EXPECT_NEAR(on_upper.z(), kGravity, 1e-3 * kGravity);
  EXPECT_NEAR(on_lower.z(), kGravity, 1e-3 * kGravity);  // 2 from the floor less 1 from above
}

// Gravity is tilted instead of the floor. friction: of the pair.
Vector3d speed_on_slope(double friction, double slope, double seconds) {
  const double angle = std::atan(0.3) * slope;
  const MixedKind kind{.restitution = 0.0,
                       .friction = friction,
                       .gravity = {kGravity * std::sin(angle), 0, -kGravity * std::cos(angle)},
                       .method = TetMethod::kImplicitEuler};
  MixedWorld world(kind.step);
  EXPECT_TRUE(world.add("block",
                        testing::tets_body(testing::tets_cube(1e6, 1), kind, {0, 0, 0.0502},
                                           Vector3d::Zero(), Vector3d::Zero()),
                        testing::contact_of(kind, Eigen::Vector3d::Ones())));
  const PlacedCollider floor = plane(friction, 0.0);
  world.set_colliders({&floor, 1});
  for (int i = 0; i < static_cast<int>(std::lround(seconds / kind.step)); ++i) {
    const Status made = world.step();
    EXPECT_TRUE(made) << i << made.error().message;
    if (!made) break;
  }
  return world.tets(0)->momentum() / world.tets(0)->model().mass();
}

TEST(TetsOnASlope, StickBelowTheAngleOfFrictionAndSlideAboveIt) {
  const double held = speed_on_slope(0.3, 0.95, 0.6).norm();
  EXPECT_LT(held, 1e-6);  // m/s; rounding and the end of the elastic ring
  const double angle = 1.5 * std::atan(0.3);
  const double early = speed_on_slope(0.3, 1.5, 0.2).x(), late = speed_on_slope(0.3, 1.5, 0.5).x();
  const double slide = kGravity * (std::sin(angle) - 0.3 * std::cos(angle));
  EXPECT_NEAR((late - early) / 0.3, slide, 5e-3 * slide);
}

// A bar of 0.04 x 0.04 x 0.4 m and 1000 kg/m^3 along z, in which waves run at 31.6 m/s.
constexpr double kLength = 0.4, kWidth = 0.04;

Model::Pointer reduced_bar() {
  static const std::string folder = fresh_folder();
  TetMesh mesh = box_mesh({2, 2, 20}, {kWidth, kWidth, kLength});
  for (Vector3d& x : mesh.vertices) x -= 0.5 * Vector3d(kWidth, kWidth, kLength);
  testing::write_veg(folder + "/bar.veg", mesh);
  const ProgramResult made =
      run_program(folder, kPrecompute +
                              "bar.veg --threads 1 --order 2 --young 1e6 --poisson 0 --density "
                              "1000 --fix none --linear-modes 80 --linear -o bar.tremolo");
  EXPECT_EQ(made.code, 0) << made.err;
  Result<Model::Pointer> model = Model::load(folder + "/bar.tremolo");
  EXPECT_TRUE(model) << model.error().message;
  return *model;
}

TetModelPointer tets_bar() {
  TetMesh mesh = box_mesh({1, 1, 16}, {kWidth, kWidth, kLength});
  for (Vector3d& x : mesh.vertices) x -= 0.5 * Vector3d(kWidth, kWidth, kLength);
  auto model = TetModel::create(mesh, {{{"gel", {1e6, 0.0, 1000.0}}}, {}}, {});
  EXPECT_TRUE(model) << model.error().message;
  return *model;
}

// St. Venant's impact of two equal bars, the lower one of tetrahedra: they are in contact for
// 2 L/c, the arriving one stops, the other continues with its speed.
TEST(MixedBars, ExchangeTheirMotionInTwoRunsOfTheWave) {
  const double speed = 0.1, c = std::sqrt(1e6 / 1000.0);
  MixedKind kind{.step = 1e-4};
  ContactOptions contact = testing::contact_of(kind, {0.5 * kWidth, 0.5 * kWidth, 0.5 * kLength});
  contact.margin = 5e-4;                   // little relative to the impact's compression,
  contact.stiffness = 16.0 * 60.0 * 60.0;  // as its contact is, of 50 us instead of 3 ms
  MixedWorld world(kind.step);
  Result<ContactBody> upper =
      ContactBody::create(reduced_bar(), "ep4", {.step = kind.step}, FrameKind::kFree);
  ASSERT_TRUE(upper) << upper.error().message;
  ASSERT_TRUE(upper->set_contact(contact));
  ASSERT_TRUE(upper->set_pose(testing::placed_at({0, 0, kLength + 5e-4})));
  ASSERT_TRUE(world.add("upper", std::move(*upper)));
  ASSERT_TRUE(world.add(
      "lower",
      testing::tets_body(tets_bar(), kind, Vector3d::Zero(), {0, 0, speed}, Vector3d::Zero()),
      contact));
  double begin = 0.0, end = 0.0;
  for (int i = 0; begin == 0.0 || world.time() < end + 0.005; ++i) {
    const Status made = world.step();
    ASSERT_TRUE(made) << i << made.error().message;
    ASSERT_LT(i, 1'000);
    if (world.account(1).active == 0) continue;
    if (begin == 0.0) begin = world.time();
    end = world.time();
  }
  const double mass = 1000.0 * kWidth * kWidth * kLength;
  const double lower = world.tets(1)->momentum().z() / mass;
  const double top = world.reduced(0)->rigid_state().velocity.z();
  EXPECT_NEAR(end - begin, 2.0 * kLength / c, 0.05 * 2.0 * kLength / c);
  EXPECT_NEAR(lower, 0.0, 0.05 * speed);
  EXPECT_NEAR(top, speed, 0.05 * speed);
}

}  // namespace
}  // namespace tremolo
