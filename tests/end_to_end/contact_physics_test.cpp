// Contact against closed forms, with default settings, at a step, its half and its quarter, and
// with few and many points: contact must not depend on either.
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/contact/islands/body_group.h"
#include "runtime/contact/solve/contact_step.h"
#include "runtime/contact_body.h"
#include "tests/support/meshes/made_cube.h"

namespace tremolo::contact_physics {
namespace {

using Eigen::Vector3d;
using testing::balance;

constexpr double kGravity = 9.81, kFriction = 0.3, kSide = 0.1;
// J. A step is solved to 1e-10 of its momenta, some N s here, at speeds below 1 m/s; what the end
// of a step and the start of the next differ by in contact energy is of that size, some ten times.
constexpr double kSolved = 1e-8;
constexpr double kSteps[] = {3e-3, 1.5e-3, 7.5e-4};
#ifdef TREMOLO_LONG_TESTS
constexpr double kLong = 600.0;  // s
#else
constexpr double kLong = 20.0;
#endif

// A cube of 0.1 m and 1 kg that nothing holds, with its middle at the mesh's origin.
ContactBody cube(const std::string& young, double step, int points, const Vector3d& gravity,
                 const Vector3d& centre) {
  const Model::Pointer model =
      testing::made_cube("physics-" + young, Vector3d::Constant(-0.5 * kSide), young, "none");
  IntegratorOptions options;
  options.step = step;
  options.beta = 2e-3;
  Result<ContactBody> body = ContactBody::create(model, "ep4", options, FrameKind::kFree);
  EXPECT_TRUE(body) << body.error().message;
  ContactOptions contact;
  contact.points = points;
  contact.shape = BoxShape{Vector3d::Constant(0.5 * kSide)};
  contact.friction = kFriction;
  EXPECT_TRUE(body->set_contact(contact));
  EXPECT_TRUE(body->set_gravity(gravity));
  EXPECT_TRUE(body->set_pose({centre, Eigen::Quaterniond::Identity()}));
  return std::move(*body);
}

const Vector3d kDown(0.0, 0.0, -kGravity), kOnFloor(0.0, 0.0, 0.5 * kSide);

std::vector<PlacedCollider> floor_plane() {
  return {{PlaneShape{}, {}, {}, kFriction, 0.5}};
}

// Steps for so many seconds.
void run(ContactBody& body, std::span<const PlacedCollider> colliders, double seconds) {
  const long steps = std::lround(seconds / body.options().step);
  for (long i = 0; i < steps; ++i) ASSERT_TRUE(body.step(colliders).converged) << i;
}

// A block that has come to rest on a belt is accelerated by mu g from the time at which the belt
// begins to glide: after 150 ms it has 0.44 m/s. The elastic path of friction, and of a soft
// block's shear, costs the same impulse at each step, 0.3 % of it at most.
TEST(ContactPhysics, ABeltThatBeginsToGlideDragsABlockThatRests) {
  for (const char* young : {"5e4", "5e7"})
    for (const int points : {8, 200})
      for (const double h : kSteps) {
        ContactBody body = cube(young, h, points, kDown, kOnFloor);
        std::vector<PlacedCollider> belt = floor_plane();
        run(body, belt, 0.6);
        const double before = body.rigid_state().velocity.x();
        const long steps = std::lround(0.15 / h);
        for (long i = 0; i < steps; ++i) {
          belt[0].start.position.x() = h * static_cast<double>(i);
          belt[0].end.position.x() = h * static_cast<double>(i + 1);
          ASSERT_TRUE(body.step(belt).converged);
        }
        const double speed = body.rigid_state().velocity.x() - before;
        EXPECT_NEAR(speed, kFriction * kGravity * 0.15, 0.005 * kFriction * kGravity * 0.15)
            << young << " " << points << " " << h;
        EXPECT_GT(body.contact_sums().friction_loss, 0.0);
        EXPECT_NEAR(balance(body), 0.0, 1e-9);
      }
}

Vector3d on_slope(double share) {
  const double angle = share * std::atan(kFriction);
  return kGravity * Vector3d(std::sin(angle), 0.0, -std::cos(angle));
}

TEST(ContactPhysics, ABlockSlidesDownASlopeAboveTheAngleOfFriction) {
  const double angle = 1.05 * std::atan(kFriction);
  const double expected = kGravity * (std::sin(angle) - kFriction * std::cos(angle));
  for (const char* young : {"5e4", "5e7"})
    for (const int points : {8, 200})
      for (const double h : kSteps) {
        ContactBody body = cube(young, h, points, on_slope(1.05), kOnFloor);
        run(body, floor_plane(), 0.6);
        const double before = body.rigid_state().velocity.x();
        run(body, floor_plane(), 0.6);
        EXPECT_NEAR((body.rigid_state().velocity.x() - before) / 0.6, expected, 0.005 * expected)
            << young << " " << points << " " << h;
      }
}

// Awake: a body that is stepped by itself does not sleep. Less than a micrometre, a two-hundredth
// of the deflection of friction's springs.
TEST(ContactPhysics, ABlockRestsOnASlopeBelowTheAngleOfFriction) {
  for (const char* young : {"5e4", "5e7"})
    for (const double h : {3e-3, 7.5e-4}) {
      ContactBody body = cube(young, h, 200, on_slope(0.95), kOnFloor);
      run(body, floor_plane(), 3.0);
      const Vector3d before = body.rigid_state().centre;
      run(body, floor_plane(), h > 1e-3 ? kLong : 0.1 * kLong);
      EXPECT_LT((body.rigid_state().centre - before).norm(), 1e-6) << young << " " << h;
    }
}

TEST(ContactPhysics, AThrownBlockStopsAfterItsSquaredSpeedOverTwiceFriction) {
  const double expected = 2.0 * 2.0 / (2.0 * kFriction * kGravity);
  for (const int points : {8, 200})
    for (const double h : kSteps) {
      ContactBody body = cube("5e7", h, points, kDown, kOnFloor);
      ASSERT_TRUE(body.set_motion({2.0, 0.0, 0.0}, Vector3d::Zero()));
      run(body, floor_plane(), 0.9);
      EXPECT_NEAR(body.rigid_state().centre.x(), expected, 0.005 * expected) << points << " " << h;
      // All of its energy goes to friction, except for the part that restitution took on the way
      // down.
      EXPECT_NEAR(body.contact_sums().friction_loss, 2.0, 0.01) << points << " " << h;
    }
}

// A body that begins on the floor gets no energy from it: its contact begins at its position. It
// sinks until contact supports it, and comes to rest.
TEST(ContactPhysics, ABlockThatIsLaidOnTheFloorStaysThere) {
  for (const char* young : {"5e4", "5e7"})
    for (const int points : {8, 200})
      for (const double h : {3e-3, 1e-3, 2.5e-4}) {
        ContactBody body = cube(young, h, points, kDown, kOnFloor);
        const double margin = body.contact()->surface().law.margin;
        const std::vector<PlacedCollider> floor = floor_plane();
        double highest = 0.0, most = 0.0;
        for (long i = 0; i < std::lround(1.0 / h); ++i) {
          ASSERT_TRUE(body.step(floor).converged);
          highest = std::max(highest, body.rigid_state().centre.z() - kOnFloor.z());
          const double rigid = 0.5 * body.rigid_state().velocity.squaredNorm();
          most = std::max(most, rigid + body.contact_account().energy);
        }
        EXPECT_LE(highest, 1e-12) << young << " " << points << " " << h;
        // A soft block sinks by its own squeezing too, 0.6 mm.
        EXPECT_LT(most, kGravity * (margin + 6e-4));
        EXPECT_NEAR(body.contact_sums().error, 0.0, kSolved);
        // The soft block on its four corners alone still swings in its own lowest mode, which beta
        // damps.
        if (points == 8) run(body, floor, 0.5);
        const double before = body.rigid_state().centre.z();
        run(body, floor, 0.3);
        EXPECT_NEAR(body.rigid_state().centre.z(), before, 1e-6) << young << " " << points;
      }
}

// Gravity brings bodies into contact within the step: one at rest just above the margin, and one
// pushed from farther away.
TEST(ContactPhysics, WhatAnAccelerationBringsInIsFound) {
  for (const double h : {1.0 / 60.0, 3e-3}) {
    const double margin = 0.005 * kSide;
    for (const double share : {0.1, 0.5, 0.9}) {
      const double gap = margin + share * 0.5 * kGravity * h * h;
      ContactBody body = cube("5e7", h, 200, kDown, kOnFloor + Vector3d(0.0, 0.0, gap));
      run(body, floor_plane(), 0.5);
      EXPECT_NEAR(body.contact_sums().error, 0.0, kSolved) << h << " " << share;
      EXPECT_NEAR(balance(body), 0.0, 1e-9) << h << " " << share;
      EXPECT_GT(body.rigid_state().centre.z(), 0.5 * kSide - 2.0 * margin);
    }
    ContactBody pushed = cube("5e7", h, 200, kDown, kOnFloor + Vector3d(0.0, 0.0, 0.002));
    for (VertexId vertex = 48; vertex < 64; ++vertex)
      ASSERT_TRUE(pushed.apply_force(vertex, {0.0, 0.0, -300.0 / 16.0}, 1'000));
    run(pushed, floor_plane(), 0.3);
    EXPECT_NEAR(pushed.contact_sums().error, 0.0, kSolved) << h;
    EXPECT_NEAR(balance(pushed), 0.0, kSolved) << h;
    // The work of load and gravity equals the energy in contact and the energy taken: there is no
    // other.
    EXPECT_LT(pushed.energy().total() + pushed.contact_account().energy, 309.0 * 0.003);
  }
}

// Two plates press a cube of 1 kg by some 20 N each and lift it: friction 1 holds it, and it does
// not creep, awake.
TEST(ContactPhysics, AGripHolds) {
  for (const double h : {3e-3, 7.5e-4}) {
    ContactBody body = cube("1e5", h, 200, kDown, Vector3d::Zero());
    std::vector<PlacedCollider> grip;
    const BoxShape plate{{0.02, 0.1, 0.1}};
    for (const double side : {-1.0, 1.0}) {
      PlacedCollider one{plate, {}, {}, 1.0, 0.0};
      one.start.position.x() = one.end.position.x() = side * (0.5 * kSide + 0.0205);
      grip.push_back(one);
    }
    PlacedCollider floor{PlaneShape{}, {}, {}, kFriction, 0.5};
    floor.start.position.z() = floor.end.position.z() = -0.5 * kSide - 5e-4;
    grip.push_back(floor);
    double lift = 0.0, slip = 0.0, held = 0.0;
    const auto steps = std::lround((h > 1e-3 ? 9.0 : 5.0) / h);
    for (long i = 0; i < steps; ++i) {
      const double t = static_cast<double>(i + 1) * h;
      const double up = t < 2.0 ? 0.0 : 0.05 * h * std::min(1.0, (t - 2.0) / 0.1);
      for (int k = 0; k < 2; ++k) {
        grip[k].start = grip[k].end;
        grip[k].end.position.z() += up;
        if (t < 1.0) grip[k].end.position.x() += (k == 0 ? 1.0 : -1.0) * 0.002 * h;
      }
      lift += up;
      ASSERT_TRUE(body.step(grip).converged) << t;
      const double now = body.rigid_state().centre.z() - lift;
      if (std::abs(t - 3.0) < 0.5 * h) held = now;
      if (t > 3.0) slip = std::max(slip, std::abs(now - held));
    }
    EXPECT_GT(body.rigid_state().centre.z(), lift - 0.002) << h;
    EXPECT_LT(slip, 1e-6) << h;
    EXPECT_NEAR(balance(body), 0.0, 1e-9) << h;
  }
}

// A modulus gives p = W (x - w/2)/size beyond the smooth beginning w: the depth at which a stiff
// block's weight rests, by the areas of its points.
TEST(ContactPhysics, AModulusSaysHowDeepABlockRests) {
  const double modulus = 2e5;
  ContactBody body = cube("5e9", 1e-3, 200, kDown, kOnFloor + Vector3d(0.0, 0.0, 1e-3));
  ContactOptions contact;
  contact.modulus = modulus;
  ASSERT_TRUE(body.set_contact(contact));
  run(body, floor_plane(), 1.5);
  const ContactPoints& points = *body.contact()->surface().points;
  double area = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points.rest[i].z() < -0.49 * kSide) area += points.areas[i];
  const double margin = body.contact()->surface().law.margin;
  const double depth = margin - (body.rigid_state().centre.z() - 0.5 * kSide);
  EXPECT_NEAR(depth, 0.05 * margin + kGravity * kSide / (modulus * area), 0.002 * depth);
  EXPECT_FALSE(body.set_contact({.modulus = 0.0}));
}

// The areas of all points together are the boundary's, however many points there are.
TEST(ContactPhysics, AreasOfPointsAddUpToTheBoundary) {
  for (const int points : {1, 8, 20, 200}) {
    const ContactBody body = cube("5e7", 1e-3, points, kDown, kOnFloor);
    double sum = 0.0;
    for (const double area : body.contact()->surface().points->areas) sum += area;
    EXPECT_NEAR(sum, 6.0 * kSide * kSide, 1e-12) << points;
  }
}

// The force on the floor is the weight, as a vector; the points' impulses add up to it.
TEST(ContactPhysics, ForcesOnTheFloorAreReportedAsVectors) {
  ContactBody body = cube("5e7", 1e-3, 200, on_slope(0.9), kOnFloor);
  const std::vector<PlacedCollider> floor = floor_plane();
  run(body, floor, 1.0);
  ASSERT_EQ(body.contact()->record().collider_impulses.size(), 1U);
  const Vector3d force = body.contact()->record().collider_impulses[0] / 1e-3;
  EXPECT_LT((force - on_slope(0.9)).norm(), 1e-4 * kGravity);
  Vector3d sum = Vector3d::Zero();
  for (const ContactedPoint& point : body.contact()->record().contacted) {
    EXPECT_FALSE(point.on_body);
    EXPECT_LT((point.normal - Vector3d::UnitZ()).norm(), 1e-12);
    EXPECT_LT(std::abs(point.position.z()), 5e-4);
    sum += point.impulse;
  }
  EXPECT_LT((sum / 1e-3 + force).norm(), 1e-12 * kGravity);
}

// Spinning blocks are thrown at the floor with steps of 1/30 s, twice as far in each as they are
// long: some steps are not solved as a whole and are subdivided. The impulse of the floor is that
// of gravity plus the blocks' momentum.
TEST(ContactPhysics, AStepThatFailsIsTakenInPartsThatCloseTheAccount) {
  const double h = 1.0 / 30.0;
  std::vector<ContactBody> blocks;
  for (int i = 0; i < 6; ++i) {
    blocks.push_back(cube("1e6", h, 200, kDown, {0.02 * i, 0.0, 0.2 + 0.16 * i}));
    ASSERT_TRUE(blocks.back().set_motion({1.0, 0.0, -6.0}, {0.0, 20.0, 0.0}));
  }
  std::vector<ContactBody*> bodies;
  double momentum = 0.0;
  const double thrown = blocks[0].energy().total();  // J, each
  for (ContactBody& block : blocks) {
    bodies.push_back(&block);
    momentum -= block.momentum().linear.z();
  }
  std::vector<StepReport> reports(bodies.size());
  BodyGroup group;
  const std::vector<PlacedCollider> floor = floor_plane();
  constexpr int kCount = 12;
  Vector3d pushed = Vector3d::Zero();
  for (int i = 0; i < kCount; ++i) {
    group.step(bodies, floor, reports);
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      ASSERT_TRUE(reports[k].converged) << i;
      pushed -= bodies[k]->contact()->record().collider_impulses[0];
    }
  }
  std::int64_t cut = 0;
  double weight = 0.0;
  for (ContactBody& block : blocks) {
    cut += block.counts().halved;
    momentum += block.momentum().linear.z();
    weight += block.model().inertia()->mass * kGravity;
    EXPECT_NEAR(balance(block), thrown, 1e-6 * thrown);
  }
  EXPECT_GT(cut, 0);
  EXPECT_NEAR(pushed.z(), weight * h * kCount + momentum, 1e-8);
}

// A cube of n^3 cells drawn out to a ball of radius R, or to a cylinder of that radius about the y
// axis, of the cells' own length.
TetMesh round_mesh(int n, double radius, bool ball) {
  TetMesh mesh = box_mesh({n, n, n}, {2.0, 2.0, 2.0});
  for (Vector3d& x : mesh.vertices) {
    x -= Vector3d::Ones();
    const Vector3d s = x.cwiseAbs2();
    if (ball)
      x = {x.x() * std::sqrt(1.0 - s.y() / 2 - s.z() / 2 + s.y() * s.z() / 3),
           x.y() * std::sqrt(1.0 - s.z() / 2 - s.x() / 2 + s.z() * s.x() / 3),
           x.z() * std::sqrt(1.0 - s.x() / 2 - s.y() / 2 + s.x() * s.y() / 3)};
    else
      x = {x.x() * std::sqrt(1.0 - s.z() / 2), x.y(), x.z() * std::sqrt(1.0 - s.x() / 2)};
    x *= radius;
  }
  return mesh;
}

// On a slope of 0.1 a ball rolls with 5/7 g sin, a cylinder with 2/3. The loss, 3 %, is due to the
// facets' edges (a tenth of a millimetre high, and lower with more of them) and to the fiftieth of
// restitution that depends on points.
TEST(ContactPhysics, ABallAndACylinderRoll) {
  constexpr double kRadius = 0.03, kSlope = 0.1;
  for (const bool ball : {true, false})
    for (const double h : {3e-3, 1.5e-3}) {
      const Model::Pointer model = testing::made_body(ball ? "ball" : "cylinder",
                                                      round_mesh(10, kRadius, ball), "5e6", "none");
      IntegratorOptions options;
      options.step = h;
      Result<ContactBody> body = ContactBody::create(model, "ep4", options, FrameKind::kFree);
      ASSERT_TRUE(body) << body.error().message;
      ASSERT_TRUE(body->set_contact({.points = 600}));
      ASSERT_TRUE(body->set_gravity(kGravity * Vector3d(std::sin(kSlope), 0, -std::cos(kSlope))));
      ASSERT_TRUE(body->set_pose({{0.0, 0.0, 0.0301}, Eigen::Quaterniond::Identity()}));
      run(*body, floor_plane(), 0.3);
      const double before = body->rigid_state().velocity.x();
      run(*body, floor_plane(), 0.6);
      const double found = (body->rigid_state().velocity.x() - before) / 0.6;
      const double expected = (ball ? 5.0 / 7.0 : 2.0 / 3.0) * kGravity * std::sin(kSlope);
      EXPECT_NEAR(found, expected, 0.03 * expected) << ball << " " << h;
      EXPECT_NEAR(balance(*body), 0.0, kSolved);
    }
}

// A rigid ball on a foundation whose pressure is W x/size: F = pi R W delta^2/size, so that an
// impact at v reaches delta^3 = 3 m v^2/2 / (pi R W/size) and F there. The error is that of the
// facets: 5 % of 9 points in the patch, 0.6 % of 40 (a ball of 20 cells).
TEST(ContactPhysics, AnImpactOnAnElasticFoundationHasItsForce) {
  constexpr double kRadius = 0.03, kModulus = 2e8, kSpeed = 2.4;
#ifdef TREMOLO_LONG_TESTS
  constexpr int kCells = 20;
  constexpr double kError = 0.01;
#else
  constexpr int kCells = 10;
  constexpr double kError = 0.06;
#endif
  const Model::Pointer model = testing::made_body("hard-ball-" + std::to_string(kCells),
                                                  round_mesh(kCells, kRadius, true), "5e9", "none");
  for (const double h : {1e-4, 5e-5}) {
    IntegratorOptions options;
    options.step = h;
    Result<ContactBody> body = ContactBody::create(model, "ep4", options, FrameKind::kFree);
    ASSERT_TRUE(body) << body.error().message;
    ASSERT_TRUE(body->set_contact({.points = 2402, .modulus = kModulus, .restitution = 1.0}));
    ASSERT_TRUE(body->set_pose({{0.0, 0.0, 0.031}, Eigen::Quaterniond::Identity()}));
    ASSERT_TRUE(body->set_motion({0.0, 0.0, -kSpeed}, Vector3d::Zero()));
    std::vector<PlacedCollider> floor = floor_plane();
    floor[0].restitution = 1.0;
    double most = 0.0;
    for (double t = 0.0; t < 0.005; t += h) {
      ASSERT_TRUE(body->step(floor).converged);
      most = std::max(most, body->contact_account().impulse_vector.z() / h);
    }
    const double k =
        std::numbers::pi * kRadius * kModulus / body->contact()->surface().points->extent;
    const double delta = std::cbrt(1.5 * model->inertia()->mass * kSpeed * kSpeed / k);
    EXPECT_NEAR(most, k * delta * delta, kError * k * delta * delta) << h;
    EXPECT_NEAR(body->rigid_state().velocity.z(), kSpeed, 0.01 * kSpeed) << h;
  }
}

// A turntable sets a block in motion with it and loses it once omega^2 r is above mu g.
TEST(ContactPhysics, ATurntableCarriesABlockUpToItsFriction) {
  constexpr double kFar = 0.2, kRamp = 1.0;
  for (const double share : {0.76, 1.2})
    for (const double h : kSteps) {
      ContactBody body = cube("5e7", h, 200, kDown, kOnFloor + Vector3d(kFar, 0.0, 0.0));
      std::vector<PlacedCollider> table = floor_plane();
      run(body, table, 0.3);
      const double rate = std::sqrt(share * kFriction * kGravity / kFar);
      const auto angle = [&](double t) {
        return t < kRamp ? 0.5 * rate * t * t / kRamp : rate * (t - 0.5 * kRamp);
      };
      const auto turned = [&](double t) {
        return Eigen::Quaterniond(Eigen::AngleAxisd(angle(t), Vector3d::UnitZ()));
      };
      double left_at = 0.0;  // rad/s
      for (double t = 0.0; t < 2.0 * kRamp; t += h) {
        table[0].start.rotation = turned(t);
        table[0].end.rotation = turned(t + h);
        ASSERT_TRUE(body.step(table).converged);
        const double far = body.rigid_state().centre.head<2>().norm();
        if (left_at == 0.0 && far > kFar + 2e-4) left_at = rate * std::min(1.0, t / kRamp);
      }
      if (share < 1.0) {
        EXPECT_EQ(left_at, 0.0) << h;
        EXPECT_NEAR(body.rigid_state().spin.z(), rate, 1e-3 * rate) << h;
        continue;
      }
      // It has slid by 0.2 mm when it is noticed, which takes some hundredths of a second.
      const double limit = std::sqrt(kFriction * kGravity / kFar);
      EXPECT_GT(left_at, 0.98 * limit) << h;
      EXPECT_LT(left_at, 1.04 * limit) << h;
    }
}

TEST(ContactPhysics, AStackExactlyOneMarginApartComesToRest) {
  for (const double h : kSteps) {
    std::vector<ContactBody> blocks;
    for (int i = 0; i < 3; ++i)
      blocks.push_back(cube("5e6", h, 200, kDown, {0.0, 0.0, 0.0505 + (kSide + 0.0005) * i}));
    const std::array<ContactBody*, 3> bodies = {&blocks[0], &blocks[1], &blocks[2]};
    std::array<StepReport, 3> reports;
    BodyGroup group;
    const std::vector<PlacedCollider> floor = floor_plane();
    for (long i = 0; i < std::lround(2.0 / h); ++i) {
      group.step(bodies, floor, reports);
      for (const StepReport& report : reports) ASSERT_TRUE(report.converged) << i << " " << h;
    }
    for (int i = 0; i < 3; ++i) {
      // Slow enough to fall asleep, 0.01 margins in 3 ms.
      EXPECT_LT(blocks[i].rigid_state().velocity.norm(), 1.7e-3) << h;
      EXPECT_NEAR(blocks[i].rigid_state().centre.z(), 0.05 + kSide * i, 1e-3) << h;
      EXPECT_NEAR(balance(blocks[i]), 0.0, 1e-9) << h;
    }
  }
}

}  // namespace
}  // namespace tremolo::contact_physics
