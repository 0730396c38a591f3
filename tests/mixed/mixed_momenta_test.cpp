// A body of tetrahedra and a reduced body in contact: momenta and energy.
#include <algorithm>
#include <array>
#include <cmath>

#include "runtime/contact/islands/body_group.h"
#include "tests/mixed/mixed_bodies.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::MixedKind;
using testing::MixedSum;
using testing::MixedWorld;

TEST(MixedBodies, KeepBothMomentaAndTheEnergyOfThePair) {
  for (const double friction : {0.0, 0.5}) {
    const MixedKind kind{.friction = friction};
    MixedWorld world(kind.step);
    ContactBody reduced =
        testing::reduced_body(testing::reduced_cube("1e5"), kind, {-0.09, 0.01, -0.02});
    ASSERT_TRUE(reduced.set_motion({1.0, 0.2, 0}, {2, 5, -1}));
    ASSERT_TRUE(world.add("reduced", std::move(reduced)));
    TetBody tets = testing::tets_body(testing::tets_cube(1e5, 2), kind, {0.09, -0.01, 0.03},
                                      {-0.8, 0, 0.1}, {-3, 1, 4});
    ASSERT_TRUE(
        world.add("tets", std::move(tets), testing::contact_of(kind, Eigen::Vector3d::Ones())));
    const MixedSum start = testing::sum_of(world);
    const Vector3d before = world.reduced(0)->momentum().linear;
    double worst_linear = 0.0, worst_angular = 0.0, worst_energy = 0.0, taken = 0.0, own = 0.0;
    int touched = 0;
    for (int i = 0; i < 150; ++i) {
      TetBody& body = *world.tets(1);
      const double tets_before = body.kinetic_energy() + body.elastic_energy();
      const Status made = world.step();
      ASSERT_TRUE(made) << i << made.error().message;
      own += body.kinetic_energy() + body.elastic_energy() - tets_before - world.account(1).work;
      touched += world.account(1).active;
      for (std::size_t k : {0U, 1U})
        taken += world.account(k).lost + world.account(k).friction_loss;
      const MixedSum now = testing::sum_of(world);
      worst_linear = std::max(worst_linear, (now.linear - start.linear).norm());
      worst_angular = std::max(worst_angular, (now.angular - start.angular).norm());
      worst_energy = std::max(worst_energy, std::abs(now.energy + taken - own - start.energy));
    }
    EXPECT_GT(touched, 5);
    EXPECT_GT((world.reduced(0)->momentum().linear - before).norm(), 0.5);
    // Sums of 1 kg m/s and 0.1 N m s: solved to 1e-10 of the forces in each step.
    EXPECT_LT(worst_linear, 1e-10);
    EXPECT_LT(worst_angular, 1e-11);
    // Contact closes to rounding; what midpoint itself adds to its body is known and of second
    // order in the step.
    EXPECT_LT(worst_energy, 1e-9 * start.energy);
    EXPECT_LT(std::abs(own), 2e-3 * start.energy);
  }
}

// Velocity of the reduced cube after a central blow of a cube of tetrahedra, m/s.
double speed_after_blow(double step) {
  const MixedKind kind{.step = step};
  MixedWorld world(step);
  EXPECT_TRUE(
      world.add("reduced", testing::reduced_body(testing::reduced_cube("1e6"), kind, {0, 0, 0})));
  EXPECT_TRUE(world.add("tets",
                        testing::tets_body(testing::tets_cube(1e6, 1), kind, {0, 0.01, 0.106},
                                           {0, 0, -1.0}, Vector3d::Zero()),
                        testing::contact_of(kind, Eigen::Vector3d::Ones())));
  const int steps = static_cast<int>(std::lround(0.03 / step));
  for (int i = 0; i < steps; ++i) {
    const Status made = world.step();
    EXPECT_TRUE(made) << made.error().message;
    if (!made) break;
  }
  EXPECT_EQ(world.account(1).active, 0);
  return world.reduced(0)->rigid_state().velocity.z();
}

TEST(MixedBodies, SettleAsTheStepIsHalved) {
  const double whole = speed_after_blow(4e-4), half = speed_after_blow(2e-4),
               quarter = speed_after_blow(1e-4), eighth = speed_after_blow(5e-5);
  const double first = std::abs(whole - quarter), second = std::abs(half - eighth);
  // Measured: -0.92846, -0.92768, -0.92750, -0.92756 m/s. Contact begins within a step, and each
  // step has another fraction of it.
  EXPECT_GT(first, 2.0 * second);
  EXPECT_NEAR(quarter, eighth, 2e-4);
}

// bdf2 passes the momentum of a step's forces on over several steps. At long steps an impact is
// taken in parts, by implicit-euler, and the step before the next one is none of bdf2's.
TEST(MixedBodies, KeepTheMomentumOfAnImpactThatBdf2TakesInParts) {
  for (const double step : {1.0 / 60.0, 6e-3, 3e-3}) {
    SCOPED_TRACE(step);
    const MixedKind kind{.step = step, .method = TetMethod::kBdf2};
    MixedWorld world(step);
    ASSERT_TRUE(
        world.add("reduced", testing::reduced_body(testing::reduced_cube("1e5"), kind, {0, 0, 0})));
    ASSERT_TRUE(world.add("tets",
                          testing::tets_body(testing::tets_cube(1e5, 2), kind, {0, 0.01, 0.103},
                                             {0, 0, -1.0}, Vector3d::Zero()),
                          testing::contact_of(kind, Vector3d::Ones())));
    const Vector3d start = testing::sum_of(world).linear;
    const int steps = static_cast<int>(std::lround(0.4 / step));
    for (int i = 0; i < steps; ++i) ASSERT_TRUE(world.step()) << i;
    EXPECT_EQ(world.account(1).active, 0);
    EXPECT_GT(world.reduced(0)->momentum().linear.norm(), 0.3);
    EXPECT_LT((testing::sum_of(world).linear - start).norm(), 1e-7 * start.norm());
  }
}

TEST(MixedBodies, ThatTouchNothingStepToTheSameBits) {
  const MixedKind kind{.gravity = {0, 0, -9.81}, .method = TetMethod::kBdf2};
  MixedWorld world(kind.step);
  const auto reduced = [&] {
    ContactBody body = testing::reduced_body(testing::reduced_cube("1e5"), kind, {0, 0, 0});
    EXPECT_TRUE(body.set_motion({1.0, 0.2, 0}, {2, 5, -1}));
    return body;
  };
  const TetModelPointer model = testing::tets_cube(1e5, 1);
  const auto tets = [&] {
    return testing::tets_body(model, kind, {1, 0, 0}, {0, 0, 0.1}, {3, 1, 4});
  };
  ContactBody reduced_alone = reduced();
  TetBody tets_alone = tets();
  ASSERT_TRUE(world.add("reduced", reduced()));
  ASSERT_TRUE(world.add("tets", tets()));
  for (int i = 0; i < 50; ++i) {
    ASSERT_TRUE(world.step());
    ASSERT_TRUE(reduced_alone.step().converged && tets_alone.step().converged);
    EXPECT_EQ(world.in_islands(), 0U);
  }
  EXPECT_EQ(world.reduced(0)->state().q, reduced_alone.state().q);
  EXPECT_EQ(world.reduced(0)->rigid_state().centre, reduced_alone.rigid_state().centre);
  EXPECT_EQ(world.tets(1)->positions(), tets_alone.positions());
  EXPECT_EQ(world.tets(1)->velocities(), tets_alone.velocities());
}

// A cube of tetrahedra and a reduced one of the same material hit like two reduced ones.
TEST(MixedBodies, HitAsTwoReducedBodiesDo) {
  const MixedKind kind{.step = 2e-4};
  const auto lower = [&] {
    return testing::reduced_body(testing::reduced_cube("1e6"), kind, {0, 0, 0});
  };
  MixedWorld mixed(kind.step), reduced(kind.step);
  ASSERT_TRUE(mixed.add("lower", lower()));
  ASSERT_TRUE(reduced.add("lower", lower()));
  ASSERT_TRUE(mixed.add("upper",
                        testing::tets_body(testing::tets_cube(1e6, 3), kind, {0, 0.01, 0.106},
                                           {0, 0, -1.0}, Vector3d::Zero()),
                        testing::contact_of(kind, Eigen::Vector3d::Ones())));
  ContactBody upper = testing::reduced_body(testing::reduced_cube("1e6"), kind, {0, 0.01, 0.106});
  ASSERT_TRUE(upper.set_motion({0, 0, -1.0}, Vector3d::Zero()));
  ASSERT_TRUE(reduced.add("upper", std::move(upper)));
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(mixed.step());
    ASSERT_TRUE(reduced.step());
  }
  const double one = mixed.reduced(0)->rigid_state().velocity.z(),
               other = reduced.reduced(0)->rigid_state().velocity.z();
  // The elements are linear in the reduced cube and quadratic in the other, and the contact points
  // differ: -0.923 and -0.936 m/s.
  EXPECT_NEAR(one, other, 0.02);
}

TEST(MixedBodies, AreRefusedByName) {
  const MixedKind kind;
  MixedWorld world(2e-3);
  const Result<std::size_t> other =
      world.add("block", testing::tets_body(testing::tets_cube(1e5, 1), kind, Vector3d::Zero(),
                                            Vector3d::Zero(), Vector3d::Zero()));
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().kind, ErrorKind::kUsage);
  EXPECT_NE(other.error().message.find("'block'"), std::string::npos) << other.error().message;
  MixedWorld same(kind.step);
  const auto add = [&](const ContactOptions& contact) {
    return same.add("block",
                    testing::tets_body(testing::tets_cube(1e5, 1), kind, Vector3d::Zero(),
                                       Vector3d::Zero(), Vector3d::Zero()),
                    contact);
  };
  EXPECT_FALSE(add({.margin = 0.0}));
  EXPECT_FALSE(add({.friction = -1.0}));
  EXPECT_FALSE(add({.restitution = 2.0}));
  EXPECT_TRUE(add({}));
  Result<ContactBody> untouchable = ContactBody::create(testing::reduced_cube("1e5"), "ep4",
                                                        {.step = kind.step}, FrameKind::kFree);
  ASSERT_TRUE(untouchable);
  EXPECT_FALSE(same.add("bare", std::move(*untouchable)));
}

}  // namespace
}  // namespace tremolo
