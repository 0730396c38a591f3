// Joints of a cloth or a body of tetrahedra to a body on several bones.
#include <algorithm>
#include <cmath>

#include "runtime/math/motion.h"
#include "tests/mixed/cloth_bodies.h"
#include "tests/support/frames/rigged_model.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::MixedKind;
using testing::MixedWorld;

constexpr double kGuestStep = 2e-3;

const testing::RiggedBar& guest_bar() {
  static const testing::RiggedBar made = testing::rigged_bar(5);
  return made;
}

// The bar of 0.6 m along x, on bones or in one frame.
ContactBody bar_for_guests(bool bones) {
  const IntegratorOptions options{.step = kGuestStep, .tolerance = 1e-12, .max_iterations = 60};
  const Model::Pointer& model = guest_bar().model;
  ContactBody body = bones ? testing::make_rigged(model, testing::bar_skin(guest_bar()), options)
                           : testing::make_framed(model, FrameKind::kDriven, options, "ep4");
  EXPECT_TRUE(body.set_contact({.points = 20, .colliders = false}));
  return body;
}

MotionPath rising_path() {
  Motion motion;
  motion.parts.push_back(GlideMotion{{0.1, 0.0, 0.4}, {.start = 0.0, .ramp = 0.05}});
  motion.parts.push_back(
      SpinMotion{{0.3, 1.0, 0.0}, {0.3, 0.05, 0.0}, 1.0, {.start = 0.0, .ramp = 0.05}});
  return *MotionPath::create(motion, {});
}

void move_bones(const MotionPath& path, std::size_t bone, ContactBody& body) {
  const double h = body.options().step, t = body.time();
  const FrameMotion motion =
      motion_between(path.pose(t - h), path.pose(t), path.pose(t + h), path.pose(t + 2 * h), h);
  ASSERT_TRUE(body.move_to(path.pose(t + h), motion, bone));
}

constexpr double kTie = 300.0, kTieLength = 0.05;  // N/m, m

// The guest 0 above the bar, tied to a place between its bones.
void add_bodies(bool cloth, bool bones, MixedWorld& world) {
  const MixedKind kind{
      .step = kGuestStep, .gravity = {0.0, 0.0, -9.81}, .method = TetMethod::kMidpoint};
  const Vector3d middle(0.4, 0.05, 0.3);
  ASSERT_TRUE(world.add("bar", bar_for_guests(bones)));
  if (cloth)
    ASSERT_TRUE(world.add(testing::sheet_body(
        {.integrator = "energy", .particles = 6, .width = 0.2, .middle = middle}, kind)));
  else
    ASSERT_TRUE(world.add("cube", testing::tets_body(testing::tets_cube(1e5, 1), kind, middle,
                                                     Vector3d::Zero(), {1.0, 2.0, -1.0})));
  GuestJoint joint;
  joint.guest = 0;
  joint.point = world.guests().point_near(0, middle - Vector3d(0.05, 0.05, 0.05));
  joint.other = 0;
  joint.along = true;
  joint.joint.second = vertex_near(*world.reduced(0), {0.4, 0.05, 0.12});
  EXPECT_EQ(joint.joint.second.bones.empty(), !bones);
  joint.joint.stiffness = kTie;
  joint.joint.damping = 0.5;
  joint.joint.length = kTieLength;
  (void)world.guests().join(joint);
}

TEST(GuestsOnBones, BonesThatMoveTogetherAreADrivenFrame) {
  const MotionPath path = rising_path();
  for (const bool cloth : {false, true}) {
    SCOPED_TRACE(cloth);
    MixedWorld driven(kGuestStep), boned(kGuestStep);
    add_bodies(cloth, false, driven);
    add_bodies(cloth, true, boned);
    double most = 0.0;
    for (int k = 0; k < 150; ++k) {
      for (MixedWorld* world : {&driven, &boned}) {
        move_bones(path, kAllBones, *world->reduced(0));
        const Status made = world->step();
        ASSERT_TRUE(made) << made.error().message;
      }
      const Vector3d one = driven.guests().joint(0)->joint.force;
      most = std::max(most, one.norm());
      ASSERT_LE((boned.guests().joint(0)->joint.force - one).norm(), 1e-8 * most) << k;
    }
    EXPECT_GT(most, 1.0);
    const Eigen::VectorXd& q = driven.reduced(0)->state().q;
    EXPECT_LE((boned.reduced(0)->state().q - q).norm(), 1e-8 * q.norm());
  }
}

// Bones that turn against each other: the joint's energy is that of the distance of its ends, with
// the work on them; the bar keeps what it gets from the joint and its bones.
TEST(GuestsOnBones, TheEnergyIsThatOfTheEnds) {
  const MotionPath path = rising_path();
  for (const bool cloth : {false, true}) {
    SCOPED_TRACE(cloth);
    MixedWorld world(kGuestStep);
    add_bodies(cloth, true, world);
    const MixedGuests& guests = world.guests();
    const GuestJoint& known = *guests.joint(0);
    ContactBody& bar = *world.reduced(0);
    const auto apart = [&] {
      return Vector3d(guests.point_at(0, known.point) - place_now(bar, known.joint.second));
    };
    const auto stored = [&] { return 0.5 * kTie * std::pow(apart().norm() - kTieLength, 2); };
    const double start = stored();
    double paid = 0.0, most = start;
    for (int k = 0; k < 150; ++k) {
      const Vector3d before = apart();
      move_bones(path, 2, bar);
      const Status made = world.step();
      ASSERT_TRUE(made) << made.error().message;
      paid -= known.joint.force.dot(apart() - before);
      most = std::max(most, bar.energy().total());
      ASSERT_NEAR(known.joint.energy, stored(), 1e-9 * most) << k;
      ASSERT_NEAR(known.joint.energy + known.joint.damped - start, paid, 1e-9 * most) << k;
      ASSERT_NEAR(bar.energy().total(),
                  bar.sums().support + bar.contact_sums().joint - bar.sums().dissipated,
                  1e-8 * most)
          << k;
    }
    EXPECT_GT(known.joint.damped, 1e-3 * start);
    EXPECT_GT(std::abs(bar.contact_sums().joint), 1e-4 * start);
  }
}

}  // namespace
}  // namespace tremolo
