// Joints between cloths, bodies of tetrahedra and reduced or rigid bodies: momenta and energy of
// the pair, closed forms of the spring and of the pendulum, contact between the joined.
#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>

#include "tests/mixed/cloth_bodies.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::MixedKind;
using testing::MixedWorld;

constexpr double kJointGravity = 9.81;

GuestJoint joint_of(std::size_t guest, std::size_t point, double stiffness, double damping,
                    double length) {
  GuestJoint made;
  made.guest = guest;
  made.point = point;
  made.along = true;
  made.joint.stiffness = stiffness;
  made.joint.damping = damping;
  made.joint.length = length;
  return made;
}

TetBody cube_at(double young, const MixedKind& kind, const Vector3d& place,
                const Vector3d& velocity) {
  return testing::tets_body(testing::tets_cube(young, 1), kind, place, velocity, {1.0, 2.0, -1.0});
}

// The guest 0, a cloth or a cube, and what it is joined to.
enum class Partner { kCloth, kTets, kReduced };
struct PairKind {
  bool cloth;
  Partner to;
  double length;
};

// Steps a pair and checks both momenta and all energy after each step.
void follow_pair(const PairKind& pair) {
  const MixedKind kind{.step = 2e-3, .method = TetMethod::kMidpoint};
  MixedWorld world(kind.step);
  if (pair.cloth)
    ASSERT_TRUE(world.add(
        testing::sheet_body({.integrator = "energy", .velocity = {0.3, 0.2, 0.5}}, kind)));
  else
    ASSERT_TRUE(world.add("cube", cube_at(1e5, kind, Vector3d::Zero(), {0.3, 0.2, 0.5})));
  MixedGuests& guests = world.guests();
  const Vector3d there(0.1, 0.05, 0.4);
  GuestJoint joint = joint_of(0, guests.point_near(0, {0.1, 0.1, 0.05}), 80.0, 0.4, pair.length);
  if (pair.to == Partner::kReduced) {
    const Model::Pointer model = testing::reduced_cube("1e5");
    ASSERT_TRUE(world.add("reduced", testing::reduced_body(model, kind, there)));
    joint.joint.second = place_at(*world.reduced(1), there - Vector3d(0.05, 0.05, 0.05));
  } else {
    if (pair.to == Partner::kTets)
      ASSERT_TRUE(world.add("other", cube_at(2e5, kind, there, {-0.5, 0.1, 0.0})));
    else
      ASSERT_TRUE(world.add(testing::sheet_body({.integrator = "energy", .middle = there}, kind)));
    joint.to_guest = true;
    joint.other = 1;
    joint.other_point = guests.point_near(1, there - Vector3d(0.2, 0.2, 0.05));
  }
  const Joint& known = guests.joint(guests.join(joint))->joint;
  const testing::MixedSum start = testing::sum_of(world);
  const double distance = (guests.point_at(0, joint.point) -
                           (joint.to_guest ? guests.point_at(1, joint.other_point)
                                           : Vector3d(there - Vector3d(0.05, 0.05, 0.05))))
                              .norm();
  const double stored = 40.0 * std::pow(distance - pair.length, 2);
  double momentum = 0.0, own = 0.0;
  for (int i = 0; i < 150; ++i) {
    double before = 0.0;
    for (std::size_t k = 0; k < 2; ++k)
      if (TetBody* tets = world.tets(k)) before += tets->kinetic_energy() + tets->elastic_energy();
    ASSERT_TRUE(world.step()) << i;
    // The energy of the tetrahedra's own method is known from the work on them alone.
    for (std::size_t k = 0; k < 2; ++k)
      if (TetBody* tets = world.tets(k)) {
        own += tets->kinetic_energy() + tets->elastic_energy() - world.account(k).joint_work;
        own -= world.account(k).work;
      }
    own -= before;
    momentum = std::max(momentum, known.force.norm() * kind.step * (i + 1));
    double cloth = 0.0;
    for (std::size_t k = 0; k < 2; ++k)
      if (world.cloth(k) != nullptr) cloth += testing::own_energy(*world.cloth(k));
    const testing::MixedSum now = testing::sum_of(world);
    ASSERT_LT((now.linear - start.linear).norm(), 1e-10 * momentum) << i;
    ASSERT_LT((now.angular - start.angular).norm(), 1e-10 * momentum) << i;
    ASSERT_NEAR(now.energy + known.energy + known.damped - own - cloth, start.energy + stored,
                1e-9 * stored)
        << i;
  }
  EXPECT_GT(momentum, 0.1);
  EXPECT_GT(known.damped, 1e-2 * stored) << "its damper is at work";
}

TEST(GuestJoint, KeepsTheMomentaAndTheEnergyOfThePair) {
  for (const PairKind& pair :
       {PairKind{true, Partner::kTets, 0.1}, PairKind{true, Partner::kReduced, 0.1},
        PairKind{true, Partner::kCloth, 0.0}, PairKind{false, Partner::kTets, 0.2},
        PairKind{false, Partner::kTets, 0.0}, PairKind{false, Partner::kReduced, 0.1},
        PairKind{false, Partner::kReduced, 0.0}}) {
    SCOPED_TRACE(std::string(pair.cloth ? "cloth" : "tets") + " to " +
                 std::to_string(static_cast<int>(pair.to)) + ", length " +
                 std::to_string(pair.length));
    follow_pair(pair);
  }
}

// Two stiff cubes of 1 kg on a spring: their distance oscillates with the frequency of the reduced
// mass, as the implicit midpoint rule has it.
TEST(GuestJoint, TwoMassesOscillateAtTheClosedForm) {
  const MixedKind kind{.step = 2e-3, .method = TetMethod::kMidpoint};
  MixedWorld world(kind.step);
  const TetModelPointer model = testing::tets_cube(1e9, 2);
  for (const double x : {0.0, 0.5})
    ASSERT_TRUE(world.add(
        "cube", testing::tets_body(model, kind, {x, 0, 0}, Vector3d::Zero(), Vector3d::Zero())));
  MixedGuests& guests = world.guests();
  constexpr double kSpring = 200.0, kLength = 0.38;  // 0.02 m longer at first
  GuestJoint joint = joint_of(0, guests.point_near(0, {0.05, 0, 0}), kSpring, 0.0, kLength);
  joint.to_guest = true;
  joint.other = 1;
  joint.other_point = guests.point_near(1, {0.45, 0, 0});
  (void)guests.join(joint);
  const double omega = std::sqrt(kSpring * 2.0 / model->mass());
  const double numerical = 2.0 / kind.step * std::atan(0.5 * kind.step * omega);
  double worst = 0.0;
  for (int i = 1; i <= 500; ++i) {
    ASSERT_TRUE(world.step());
    const double longer =
        (guests.point_at(1, joint.other_point) - guests.point_at(0, joint.point)).norm() - kLength;
    worst = std::max(worst, std::abs(longer - 0.02 * std::cos(numerical * i * kind.step)));
  }
  EXPECT_LT(worst, 1e-3 * 0.02);
}

// A stiff cube on a string of a metre swings with the period of the double pendulum of string and
// cube, from a particle of a sheet that does not move.
TEST(GuestJoint, ACubeOnAStringIsAPendulum) {
  const MixedKind kind{
      .step = 2e-3, .gravity = {0, 0, -kJointGravity}, .method = TetMethod::kMidpoint};
  MixedWorld world(kind.step);
  constexpr double kLength = 1.0, kSide = 0.1, kStiffness = 1e5, kAngle = 0.02;
  const double a = 0.5 * kSide, turning = kSide * kSide / 6.0;  // I/m of a cube
  Eigen::Matrix2d inertia, weight;
  inertia << kLength * kLength, kLength * a, kLength * a, a * a + turning;
  weight << kJointGravity * kLength, 0.0, 0.0, kJointGravity * a;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix2d> modes(weight, inertia);
  const double omega = std::sqrt(modes.eigenvalues()[0]);
  const Eigen::Vector2d mode = kAngle * modes.eigenvectors().col(0) / modes.eigenvectors()(0, 0);
  const TetModelPointer model = testing::tets_cube(1e8, 2);
  const double taut = kLength + model->mass() * kJointGravity / kStiffness;
  const Vector3d end(taut * std::sin(mode[0]), 0.0, -taut * std::cos(mode[0]));
  TetBody cube =
      testing::tets_body(model, kind, Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero());
  const Eigen::AngleAxisd turn(-mode[1], Vector3d::UnitY());
  Eigen::VectorXd x = model->rest();
  for (Eigen::Index i = 0; i < x.size(); i += 3)
    x.segment<3>(i) = end + turn * Vector3d(x.segment<3>(i) - Vector3d(0, 0, a));
  ASSERT_TRUE(cube.set_state(x, Eigen::VectorXd::Zero(x.size())));
  ASSERT_TRUE(world.add("cube", std::move(cube)));
  ClothScene anchor = testing::sheet_scene({.particles = 3, .width = 0.02}, kind);
  anchor.cloths.front().pins.emplace_back().particles = {0, 1, 2, 3, 4, 5, 6, 7, 8};
  Result<ClothBody> sheet = ClothBody::create(anchor);
  ASSERT_TRUE(sheet) << sheet.error().message;
  ASSERT_TRUE(world.add(std::move(*sheet)));
  MixedGuests& guests = world.guests();
  GuestJoint joint = joint_of(0, guests.point_near(0, end), kStiffness, 0.0, kLength);
  joint.to_guest = true;
  joint.other = 1;
  joint.other_point = 4;
  ASSERT_LT((guests.point_at(0, joint.point) - end).norm(), 1e-9);
  (void)guests.join(joint);
  double worst = 0.0, pull = 0.0;
  int steps = 0;
  const double period = 2.0 * std::numbers::pi / omega;
  for (int i = 1; i * kind.step < 1.5 * period; ++i) {
    ASSERT_TRUE(world.step()) << i;
    pull += guests.joint(0)->joint.force.norm();
    ++steps;
    const double expected = taut * mode[0] * std::cos(omega * i * kind.step);
    worst = std::max(worst, std::abs(guests.point_at(0, joint.point).x() - expected));
  }
  EXPECT_LT(worst, 3e-3 * taut * kAngle);
  const double weight_of_cube = model->mass() * kJointGravity;
  EXPECT_NEAR(pull / steps, weight_of_cube, 2e-3 * weight_of_cube);
}

// A sheet hangs on a cube that a hand holds: both springs are longer by what hangs on them.
TEST(GuestJoint, CarriesTheWeightOfWhatHangsOnIt) {
  MixedKind kind{.step = 0.02,
                 .gravity = {0, 0, -kJointGravity},
                 .method = TetMethod::kImplicitEuler,
                 .beta = 0.01};
  MixedWorld world(kind.step);
  ASSERT_TRUE(
      world.add("cube", testing::tets_body(testing::tets_cube(1e5, 2), kind, {0.0, 0.15, 0.4},
                                           Vector3d::Zero(), Vector3d::Zero())));
  ASSERT_TRUE(world.add(testing::sheet_body({}, kind)));
  MixedGuests& guests = world.guests();
  const std::size_t top = guests.point_near(0, {0.0, 0.15, 0.45});
  ASSERT_TRUE(guests.hold(0, top, {400.0, 20.0}));
  GuestJoint joint = joint_of(1, guests.point_near(1, {0.0, 0.15, 0.0}), 20.0, 0.5, 0.3);
  joint.to_guest = true;
  joint.other = 0;
  joint.other_point = guests.point_near(0, {0.0, 0.15, 0.35});
  (void)guests.join(joint);
  for (int i = 0; i < 3000; ++i) ASSERT_TRUE(world.step()) << i;
  const double sheet = world.cloth(1)->mass() * kJointGravity;
  const double all = sheet + world.tets(0)->model().mass() * kJointGravity;
  const double length =
      (guests.point_at(1, joint.point) - guests.point_at(0, joint.other_point)).norm();
  EXPECT_NEAR(length - 0.3, sheet / 20.0, 1e-5 * sheet / 20.0);
  EXPECT_NEAR(guests.joint(0)->joint.force.z(), sheet, 1e-5 * sheet);
  EXPECT_NEAR(guests.hand(0)->force.z(), all, 1e-5 * all);
}

// Joined bodies pass through each other unless the joint lets them touch; parted, they touch.
TEST(GuestJoint, LetsTheJoinedPassThroughEachOther) {
  for (const bool touch : {false, true}) {
    SCOPED_TRACE(touch);
    const MixedKind kind{.step = 2e-3, .friction = 0.3, .method = TetMethod::kMidpoint};
    MixedWorld world(kind.step);
    ASSERT_TRUE(world.add("cube", cube_at(1e5, kind, Vector3d::Zero(), {0, 0, 0.5})));
    const Model::Pointer model = testing::reduced_cube("1e5");
    ASSERT_TRUE(world.add("reduced", testing::reduced_body(model, kind, {0, 0, 0.13})));
    MixedGuests& guests = world.guests();
    GuestJoint joint = joint_of(0, guests.point_near(0, {0, 0, -0.05}), 1.0, 0.0, 0.1);
    joint.joint.second = place_at(*world.reduced(1), {0, 0, 0.18});
    joint.joint.touch = touch;
    const std::size_t number = guests.join(joint);
    for (int i = 0; i < 60; ++i) ASSERT_TRUE(world.step()) << i;
    EXPECT_EQ(guests.contacts(0) > 0 || world.account(1).active > 0 || guests.sums(0).work != 0.0,
              touch);
    guests.separate(number);
    EXPECT_EQ(guests.joint(number), nullptr);
  }
}

}  // namespace
}  // namespace tremolo
