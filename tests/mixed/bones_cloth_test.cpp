// A sheet of cloth on a body on several bones.
#include <memory>

#include "runtime/math/motion.h"
#include "tests/mixed/cloth_bodies.h"
#include "tests/support/distance_fields.h"
#include "tests/support/frames/rigged_model.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::MixedKind;
using testing::MixedWorld;
using testing::RiggedBar;
using testing::Sheet;

// The bar of 0.6 m, on bones or in one frame, with its solid.
ContactBody bar_of(const RiggedBar& bar, bool bones, const MixedKind& kind) {
  const IntegratorOptions options{.step = kind.step, .tolerance = 1e-12, .max_iterations = 60};
  ContactBody body = bones ? testing::make_rigged(bar.model, testing::bar_skin(bar), options)
                           : testing::make_framed(bar.model, FrameKind::kDriven, options, "ep4");
  ContactOptions contact = testing::contact_of(kind, Vector3d::Ones());
  contact.points = 60;
  contact.shape = GridShape{std::make_shared<const DistanceGrid>(
      testing::grid_of({{-0.1, -0.1, -0.1}, 0.0125, {65, 25, 27}}, [](const Vector3d& x) {
        return testing::box_formula({0.3, 0.05, 0.06})(x - Vector3d(0.3, 0.05, 0.06));
      }))};
  EXPECT_TRUE(body.set_contact(contact));
  return body;
}

// Rises and turns.
MotionPath rising() {
  Motion motion;
  motion.parts.push_back(GlideMotion{{0.1, 0.0, 0.4}, {.start = 0.0, .ramp = 0.05}});
  motion.parts.push_back(
      SpinMotion{{0.3, 1.0, 0.0}, {0.3, 0.05, 0.0}, 1.0, {.start = 0.0, .ramp = 0.05}});
  return *MotionPath::create(motion, {});
}

void move(const MotionPath& path, std::size_t bone, ContactBody& body) {
  const double h = body.options().step, t = body.time();
  const FrameMotion motion =
      motion_between(path.pose(t - h), path.pose(t), path.pose(t + h), path.pose(t + 2 * h), h);
  ASSERT_TRUE(body.move_to(path.pose(t + h), motion, bone));
}

Sheet sheet_over(double x) {
  return {.integrator = "energy",
          .particles = 7,
          .width = 0.2,
          .middle = {x, 0.05, 0.123},
          .velocity = {0.0, 0.0, -0.3}};
}

TEST(ClothOnBones, BonesThatMoveTogetherAreADrivenFrame) {
  const RiggedBar bar = testing::rigged_bar(5);
  const MixedKind kind{.restitution = 0.2, .friction = 0.4, .gravity = {0.0, 0.0, -9.81}};
  const MotionPath path = rising();
  MixedWorld driven(kind.step), boned(kind.step);
  for (MixedWorld* world : {&driven, &boned}) {
    ASSERT_TRUE(world->add("bar", bar_of(bar, world == &boned, kind)));
    ASSERT_TRUE(world->add(testing::sheet_body(sheet_over(0.3), kind)));
  }
  int touched = 0;
  for (int k = 0; k < 150; ++k) {
    for (MixedWorld* world : {&driven, &boned}) {
      move(path, kAllBones, *world->reduced(0));
      const Status made = world->step();
      ASSERT_TRUE(made) << made.error().message;
      // The force that pushes the sheet pushes the bar back.
      ASSERT_LE((world->account(0).impulse_vector + world->account(1).impulse_vector).norm(),
                1e-14);
    }
    touched += boned.account(1).active;
    const Eigen::VectorXd one = driven.cloth(1)->state().x, other = boned.cloth(1)->state().x;
    ASSERT_LE((one - other).cwiseAbs().maxCoeff(), 1e-7) << k;
    ASSERT_NEAR(driven.account(1).given, boned.account(1).given, 1e-9) << k;
  }
  EXPECT_GT(touched, 500);
}

TEST(ClothOnBones, ABoneThatRisesLiftsASheetAndTheEnergyOfThePairCloses) {
  const RiggedBar bar = testing::rigged_bar(5);
  const MixedKind kind{.restitution = 0.2, .friction = 0.4};
  const MotionPath path = rising();
  MixedWorld world(kind.step);
  ASSERT_TRUE(world.add("bar", bar_of(bar, true, kind)));
  ASSERT_TRUE(world.add(testing::sheet_body(sheet_over(0.5), kind)));
  const double start = testing::sum_of(world).energy;
  double given = 0.0, taken = 0.0, largest = 0.0;
  for (int k = 0; k < 150; ++k) {
    move(path, 2, *world.reduced(0));
    const Status made = world.step();
    ASSERT_TRUE(made) << made.error().message;
    for (std::size_t i = 0; i < 2; ++i) {
      given += world.account(i).given;
      taken += world.account(i).lost + world.account(i).friction_loss;
    }
    const double energy = testing::sum_of(world).energy;
    largest = std::max(largest, energy);
    ASSERT_NEAR(energy,
                start + given - taken + testing::own_energy(*world.cloth(1)) +
                    world.reduced(0)->sums().support,
                1e-6 * largest)
        << k;
  }
  EXPECT_GT(given, 1e-4);
}

}  // namespace
}  // namespace tremolo
