// Bodies on bones: agreement with a driven frame, the forces of their bones against differences of
// the positions of their points, balances.
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/bodies/reduced/bones/bone_weights.h"
#include "runtime/math/motion.h"
#include "tests/support/dynamics.h"
#include "tests/support/frames/frame_models.h"
#include "tests/support/frames/rigged_model.h"
#include "tests/support/held_case.h"

namespace tremolo {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::bar_bones;
using testing::bar_skin;
using testing::kDrivenMethods;
using testing::make_framed;
using testing::make_rigged;
using testing::rigged_bar;
using testing::RiggedBar;

// Smooth, and of each bone another one.
MotionPath path_of(int bone) {
  Motion motion;
  motion.parts.push_back(
      ShakeMotion{{0.02, -0.01, 0.03}, 3.0, {.start = -1.0, .end = 100.0, .ramp = 0.5}});
  const double rate = 3.0 - 2.0 * bone;
  motion.parts.push_back(SpinMotion{{0.3, 0.5 + bone, 1.0}, {0.1, 0.2, -0.1}, rate, {}});
  return *MotionPath::create(motion, {{0.2, 0.0, 0.1}, Eigen::Quaterniond(0.6, 0.0, 0.8, 0.0)});
}

FrameMotion motion_in_step(const MotionPath& path, double t, double h) {
  return motion_between(path.pose(t - h), path.pose(t), path.pose(t + h), path.pose(t + 2 * h), h);
}

// One step, each bone along its path.
StepReport step_bones(const std::vector<MotionPath>& paths, ContactBody& body) {
  const double h = body.options().step, t = body.time();
  for (std::size_t b = 0; b < paths.size(); ++b)
    EXPECT_TRUE(body.move_to(paths[b].pose(t + h), motion_in_step(paths[b], t, h), b));
  return body.step();
}

void begin_bones(const std::vector<MotionPath>& paths, ContactBody& body) {
  for (std::size_t b = 0; b < paths.size(); ++b) ASSERT_TRUE(body.set_pose(paths[b].pose(0.0), b));
}

std::vector<double> positions_of(const ContactBody& body) {
  std::vector<double> places(3 * body.model().drawn().rest.size());
  EXPECT_TRUE(body.surface_positions(std::span<double>(places)));
  return places;
}

TEST(Skeleton, OneBoneTakesTheBitsOfADrivenFrame) {
  const RiggedBar bar = rigged_bar(5);
  const std::vector<MotionPath> paths = {path_of(0)};
  const std::vector<BoneSegment> one = {bar_bones()[0]};
  for (const char* method : kDrivenMethods) {
    const IntegratorOptions options{.step = 3e-3, .alpha = 0.1, .beta = 1e-3};
    ContactBody driven = make_framed(bar.model, FrameKind::kDriven, options, method);
    ContactBody boned =
        make_rigged(bar.model, *skin_near_bones(*bar.model, one, 0.1), options, method);
    ASSERT_TRUE(driven.set_pose(paths[0].pose(0.0)));
    begin_bones(paths, boned);
    for (ContactBody* body : {&driven, &boned}) {
      ASSERT_TRUE(body->set_gravity({0.0, 2.0, -9.81}));
      ASSERT_TRUE(body->add_default_load({.kind = SignalKind::kSine}, 3.0));
    }
    const double h = driven.options().step;
    for (int k = 0; k < 200; ++k) {
      const double t = driven.time();
      ASSERT_TRUE(driven.move_to(paths[0].pose(t + h), motion_in_step(paths[0], t, h)));
      ASSERT_TRUE(driven.step().converged);
      ASSERT_TRUE(step_bones(paths, boned).converged);
    }
    EXPECT_GT(driven.state().q.norm(), 1e-3);
    EXPECT_EQ(driven.state().q, boned.state().q) << method;
    EXPECT_EQ(driven.state().p, boned.state().p) << method;
    EXPECT_EQ(driven.sums().support, boned.sums().support) << method;
    EXPECT_EQ(positions_of(driven), positions_of(boned)) << method;
  }
}

TEST(Skeleton, BonesThatMoveTogetherAreADrivenFrame) {
  const RiggedBar bar = rigged_bar(5);
  const MotionPath path = path_of(0);
  const std::vector<MotionPath> paths(3, path);
  for (const char* method : kDrivenMethods) {
    const IntegratorOptions options{.step = 3e-3, .tolerance = 1e-12, .max_iterations = 60};
    ContactBody driven = make_framed(bar.model, FrameKind::kDriven, options, method);
    ContactBody boned = make_rigged(bar.model, bar_skin(bar), options, method);
    ASSERT_TRUE(driven.set_pose(path.pose(0.0)));
    begin_bones(paths, boned);
    const double h = driven.options().step;
    for (int k = 0; k < 200; ++k) {
      const double t = driven.time();
      ASSERT_TRUE(driven.move_to(path.pose(t + h), motion_in_step(path, t, h)));
      ASSERT_TRUE(driven.step().converged);
      ASSERT_TRUE(step_bones(paths, boned).converged);
    }
    const VectorXd &one = driven.state().q, &other = boned.state().q;
    // The integrals sum to the whole's to rounding; 200 steps and the solves add a little.
    EXPECT_LE((one - other).norm(), 1e-11 * one.norm()) << method;
    EXPECT_NEAR(driven.sums().support, boned.sums().support, 1e-11 * driven.energy().total());
  }
}

TEST(Skeleton, SavedInMotionItGoesOnWithTheSameBits) {
  const RiggedBar bar = rigged_bar(5);
  const std::vector<MotionPath> paths = {path_of(0), path_of(1), path_of(2)};
  ContactBody body = make_rigged(bar.model, bar_skin(bar), {.step = 3e-3});
  ASSERT_TRUE(body.set_gravity({0.0, 2.0, -9.81}));
  begin_bones(paths, body);
  for (int k = 0; k < 50; ++k) ASSERT_TRUE(step_bones(paths, body).converged);
  ContactBody other = make_rigged(bar.model, bar_skin(bar), {.step = 3e-3});
  ASSERT_TRUE(other.restore(body.save()));
  for (int k = 0; k < 50; ++k)
    for (ContactBody* one : {&body, &other}) ASSERT_TRUE(step_bones(paths, *one).converged);
  EXPECT_EQ(body.state().q, other.state().q);
  EXPECT_EQ(body.state().p, other.state().p);
  EXPECT_EQ(body.sums().support, other.sums().support);
  EXPECT_EQ(positions_of(body), positions_of(other));
  // Another skin is another body.
  const std::vector<BoneSegment> bones = bar_bones();
  ContactBody narrow =
      make_rigged(bar.model, *skin_near_bones(*bar.model, bones, 0.02), {.step = 3e-3});
  EXPECT_FALSE(narrow.restore(body.save()));
}

TEST(Skeleton, BonesThatStandStillAreAHeldBody) {
  const RiggedBar bar = rigged_bar(5);
  for (const char* method : kDrivenMethods) {
    ContactBody fixed = make_framed(bar.model, FrameKind::kFixed, {}, method);
    ContactBody boned = make_rigged(bar.model, bar_skin(bar), {}, method);
    for (ContactBody* body : {&fixed, &boned})
      ASSERT_TRUE(
          body->set_state(testing::random_vector(5, 0.02, 1), testing::random_vector(5, 0.3, 2)));
    testing::steps_of(fixed, 200);
    testing::steps_of(boned, 200);
    EXPECT_EQ(fixed.state().q, boned.state().q) << method;
    EXPECT_EQ(fixed.state().p, boned.state().p) << method;
    const std::vector<double> one = positions_of(fixed), other = positions_of(boned);
    // Weights sum to one to rounding.
    for (std::size_t i = 0; i < one.size(); ++i) ASSERT_NEAR(one[i], other[i], 1e-15) << method;
  }
}

TEST(Skeleton, BalanceClosesWithDampingLoadGravityAndBonesThatTurn) {
  const RiggedBar bar = rigged_bar(6);
  const std::vector<MotionPath> paths = {path_of(0), path_of(1), path_of(2)};
  for (const char* method : {"avf", "ep2", "ep4"}) {
    ContactBody body =
        make_rigged(bar.model, bar_skin(bar), {.step = 3e-3, .alpha = 0.2, .beta = 1e-3}, method);
    begin_bones(paths, body);
    ASSERT_TRUE(body.set_gravity({0.0, 2.0, -9.81}));
    ASSERT_TRUE(body.add_default_load({.kind = SignalKind::kSine}, 5.0));
    const auto balance = testing::balance_of(body, 2000, [&] { return step_bones(paths, body); });
    testing::expect_balance(balance, body, method);
    EXPECT_GT(body.sums().dissipated, 0.1 * balance.most) << method;
  }
}

// Second derivative by differences of fourth order.
template <class Function>
Vector3d second_difference(const Function& x, double bit) {
  return (-x(2 * bit) + 16.0 * x(bit) - 30.0 * x(0.0) + 16.0 * x(-bit) - x(-2 * bit)) /
         (12.0 * bit * bit);
}

// The effect of the bones' motion on the coordinates at (q, v) and at time t, from the points: by
// the masses that ride on the bones, and by the skin's own field x = sum_b w_b T_b (X + U q).
// between: the formula of docs/theory.md for the difference of the two.
struct BoneForces {
  VectorXd shares, field, between;
};

BoneForces forces_by_differences(const testing::PointCloud& cloud, const BoneWeights& weights,
                                 const std::vector<MotionPath>& paths, const VectorXd& q,
                                 const VectorXd& v, double t) {
  constexpr double kBit = 2e-3;
  const VectorXd zero = VectorXd::Zero(q.size());
  BoneForces forces{zero, zero, zero};
  for (std::size_t k = 0; k < cloud.masses.size(); ++k) {
    const double m = cloud.masses[k];
    const MatrixXd phi = cloud.basis.middleRows(3 * static_cast<Eigen::Index>(k), 3);
    const auto w = weights.row(k);
    std::vector<Vector3d> felt;
    std::vector<Eigen::Matrix3d> turns;
    Vector3d of_field = Vector3d::Zero();
    Eigen::Matrix3d F = Eigen::Matrix3d::Zero();
    for (std::size_t b = 0; b < paths.size(); ++b) {
      const auto x = [&](double s) {
        return Vector3d(paths[b].pose(t + s) * Vector3d(cloud.places[k] + phi * (q + s * v)));
      };
      felt.push_back(second_difference(x, kBit));
      turns.push_back(paths[b].pose(t).rotation.toRotationMatrix());
      const double weight = w[b];
      of_field += weight * felt[b];
      F += weight * turns[b];
      forces.shares -= m * weight * phi.transpose() * turns[b].transpose() * felt[b];
    }
    forces.field -= m * phi.transpose() * F.transpose() * of_field;
    for (std::size_t a = 0; a < paths.size(); ++a)
      for (std::size_t b = 0; b < paths.size(); ++b)
        forces.between -= 0.5 * m * w[a] * w[b] * phi.transpose() *
                          (turns[a] - turns[b]).transpose() * (felt[a] - felt[b]);
  }
  return forces;
}

// The same as the frame has it, its motion at time t being known.
VectorXd force_of_bones(const Skin& skin, const std::vector<MotionPath>& paths, const VectorXd& q,
                        const VectorXd& v, double t) {
  constexpr double kStep = 1e-4;
  DrivenFrame frame(skin.shares, kStep);
  for (std::size_t b = 0; b < paths.size(); ++b) {
    const double from = t - 0.5 * kStep;
    frame.teleport(paths[b].pose(from), b);
    frame.move_to(paths[b].pose(from + kStep), motion_in_step(paths[b], from, kStep), b);
  }
  frame.prepare(Vector3d::Zero());
  VectorXd none = VectorXd::Zero(q.size()), opposite = none;
  const VectorXd d = kStep * v;
  frame.begin(kStep, q - 0.5 * d, v);
  frame.evaluate(d, none, none, opposite);
  return frame.push() - opposite;
}

TEST(Skeleton, ForceIsThatOfTheSkinnedPositionsInTheirSecondDifference) {
  const VectorXd q = testing::random_vector(4, 0.05, 8), v = testing::random_vector(4, 0.5, 9);
  const std::vector<MotionPath> paths = {path_of(0), path_of(1), path_of(2)};
  for (const int order : {1, 2}) {
    const RiggedBar bar = rigged_bar(4, order);
    // Blended by elements: a point has the mean weight of its tetrahedron.
    for (const double blend : {1e-9, 0.15}) {
      const BoneWeights weights = testing::weights_of_points(bar, bar_bones(), blend);
      const BoneForces expected = forces_by_differences(bar.cloud, weights, paths, q, v, 0.3);
      const VectorXd force = force_of_bones(*bar_skin(bar, blend), paths, q, v, 0.3);
      std::printf("order %d, blend %g: off by %.1e, from the field by %.2f of %.3g\n", order, blend,
                  (force - expected.shares).norm() / force.norm(),
                  (force - expected.field).norm() / force.norm(), force.norm());
      // The differences are of fourth order in 2 ms, the frame's of second order in 0.1 ms.
      EXPECT_LE((force - expected.shares).norm(), 1e-5 * force.norm());
      EXPECT_LE((expected.shares - expected.field - expected.between).norm(), 1e-10 * force.norm());
    }
  }
}

// If each point belongs to one bone, nothing is left out.
TEST(Skeleton, ForceOnPointsOfOneBoneEachIsThatOfTheSkinsOwnField) {
  const VectorXd q = testing::random_vector(4, 0.05, 8), v = testing::random_vector(4, 0.5, 9);
  const std::vector<MotionPath> paths = {path_of(0), path_of(1), path_of(2)};
  const RiggedBar bar = rigged_bar(4);
  BoneWeights weights = BoneWeights::Zero(std::ssize(bar.elements), 3);
  Skin skin;
  for (std::size_t b = 0; b < 3; ++b) {
    testing::PointCloud carried = bar.cloud;
    for (std::size_t k = 0; k < carried.masses.size(); ++k) {
      const bool here = (bar.elements[k] * 7 + 3) % 3 == b;
      weights(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(b)) = here ? 1.0 : 0.0;
      if (!here) carried.masses[k] = 0.0;
    }
    skin.shares.push_back(std::make_shared<const FrameInertia>(testing::integrals_of(carried),
                                                               Vector3d(Vector3d::Zero())));
  }
  const BoneForces expected = forces_by_differences(bar.cloud, weights, paths, q, v, 0.3);
  const VectorXd force = force_of_bones(skin, paths, q, v, 0.3);
  EXPECT_GT(force.norm(), 1.0);
  EXPECT_LE((force - expected.field).norm(), 1e-5 * force.norm());
}

// Newton's laws of the mass parts by the classical method of Runge and Kutta.
State run_shares(const testing::HeldCase& held, const BoneWeights& weights,
                 const std::vector<MotionPath>& paths, int steps) {
  return testing::runge_kutta(
      held.start, held.kTime, steps, [&](double at, const VectorXd& q, const VectorXd& v) {
        return State{v, forces_by_differences(held.cloud, weights, paths, q, v, at).shares -
                            testing::strain_force(held.strain, q) - held.damping(q, v)};
      });
}

TEST(Skeleton, FollowsNewtonsLawsOfItsSharesInSecondOrder) {
  const testing::HeldCase held;
  const std::vector<MotionPath> paths = {path_of(0), path_of(1), path_of(2)};
  const Vector3d middle = Vector3d::Zero();
  const std::vector<BoneSegment> bones = {
      {{-0.4, 0.0, 0.1}, middle}, {middle, {0.3, 0.0, 0.0}}, {{0.4, 0.2, 0.1}, middle}};
  const BoneWeights weights = weights_near(held.cloud.places, bones, 0.3);
  Skin skin{weights, weights, BoneWeights(0, 3), {}};
  for (Eigen::Index b = 0; b < 3; ++b) {
    testing::PointCloud carried = held.cloud;
    for (std::size_t k = 0; k < carried.masses.size(); ++k)
      carried.masses[k] *= weights(static_cast<Eigen::Index>(k), b);
    skin.shares.push_back(std::make_shared<const FrameInertia>(testing::integrals_of(carried),
                                                               Vector3d(Vector3d::Zero())));
  }
  const auto shared = std::make_shared<const Skin>(skin);
  const State exact = run_shares(held, weights, paths, 3000);
  for (const char* method : kDrivenMethods)
    testing::expect_second_order(method, exact.q, [&](int steps) {
      ContactBody body = make_rigged(held.model, shared, testing::held_options(steps), method);
      begin_bones(paths, body);
      EXPECT_TRUE(body.set_state(held.start.q, held.start.p));
      for (int k = 0; k < steps; ++k) EXPECT_TRUE(step_bones(paths, body).converged);
      return body.state().q;
    });
}

TEST(Skeleton, SharesOfTheInertiaSumToTheWholeAndAreThoseOfThePoints) {
  for (const int order : {1, 2}) {
    const RiggedBar bar = rigged_bar(4, order);
    const BoneWeights points = testing::weights_of_points(bar, bar_bones(), 0.1);
    const BoneWeights surface = weights_near(bar.model->surface().rest, bar_bones(), 0.1);
    const BoneWeights interior = weights_near(bar.data.interior.rest, bar_bones(), 0.1);
    const auto shares = share_inertia({bar.model->surface(), bar.data.interior, bar.data.elements,
                                       bar.data.edges, *bar.data.inertia},
                                      surface, interior);
    ASSERT_TRUE(shares) << shares.error().message;
    ASSERT_EQ(shares->size(), 3U);
    InertiaIntegrals sum = *bar.data.inertia;
    for (std::size_t b = 0; b < 3; ++b) {
      const InertiaIntegrals& share = (*shares)[b];
      testing::PointCloud carried = bar.cloud;
      for (std::size_t k = 0; k < carried.masses.size(); ++k)
        carried.masses[k] *= points(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(b));
      const InertiaIntegrals expected = testing::integrals_of(carried);
      EXPECT_NEAR(share.mass, expected.mass, 1e-12 * sum.mass);
      EXPECT_LE((share.linear - expected.linear).norm(), 1e-12 * expected.linear.norm());
      EXPECT_LE((share.B - expected.B).norm(), 1e-12 * expected.B.norm());
      EXPECT_LE((share.second_moment - expected.second_moment).norm(),
                1e-12 * expected.second_moment.norm());
    }
    for (const InertiaIntegrals& share : *shares) {
      sum.mass -= share.mass;
      sum.linear -= share.linear;
      sum.B -= share.B;
    }
    EXPECT_LE(std::abs(sum.mass), 1e-14 * bar.data.inertia->mass);
    EXPECT_LE(sum.linear.norm(), 1e-14 * bar.data.inertia->linear.norm());
    EXPECT_LE(sum.B.norm(), 1e-14 * bar.data.inertia->B.norm());
  }
}

TEST(Skeleton, VerticesAreWhereTheBlendOfTheirBonesIs) {
  const RiggedBar bar = rigged_bar(5);
  const auto skin = bar_skin(bar);
  const std::vector<MotionPath> paths = {path_of(0), path_of(1), path_of(2)};
  ContactBody body = make_rigged(bar.model, skin, {.step = 3e-3});
  begin_bones(paths, body);
  for (int k = 0; k < 100; ++k) ASSERT_TRUE(step_bones(paths, body).converged);
  const std::vector<double> drawn = positions_of(body);
  std::vector<float> floats(drawn.size()), normals(drawn.size());
  ASSERT_TRUE(body.surface(floats, normals));
  int blends = 0;
  for (VertexId id = 0; id < static_cast<VertexId>(bar.mesh.vertices.size()); ++id) {
    const VertexRows rows = *bar.model->vertex(id);
    const BoneWeights w = weights_near(std::span(&rows.rest, 1), bar_bones(), 0.08);
    if (w.maxCoeff() < 1.0) ++blends;
    const bool held = rows.rows.isZero(0.0);
    EXPECT_EQ(held, rows.rest.x() == 0.0);
    // A fixed vertex is at the blend of its rest position.
    Vector3d expected = Vector3d::Zero();
    for (std::size_t b = 0; b < 3; ++b)
      expected += w(0, static_cast<Eigen::Index>(b)) *
                  (body.pose(b) * Vector3d(rows.rest + rows.rows * body.state().q));
    EXPECT_LE((*body.position(id) - expected).norm(), 1e-15) << id;
    const std::vector<VertexId>& ids = bar.model->surface().vertex_ids;
    const auto at = std::find(ids.begin(), ids.end(), id) - ids.begin();
    if (at == std::ssize(ids)) continue;
    const std::size_t i = 3 * at;
    EXPECT_LE((Vector3d(drawn[i], drawn[i + 1], drawn[i + 2]) - expected).norm(), 1e-15);
    EXPECT_LE((Vector3d(floats[i], floats[i + 1], floats[i + 2]) - expected).norm(), 1e-6);
  }
  EXPECT_GT(blends, 20);
}

TEST(Skeleton, ForceOnAVertexDoesItsWorkOnTheSkinnedPlace) {
  const RiggedBar bar = rigged_bar(5, 2, 0.0);
  const auto skin = bar_skin(bar);
  ContactBody body = make_rigged(bar.model, skin, {.step = 3e-3, .tolerance = 1e-12});
  for (std::size_t b = 0; b < 3; ++b)
    ASSERT_TRUE(body.set_pose({{0.1, 0.2, 0.3}, turn_by({0.0, 0.5 * double(b), 1.0})}, b));
  // Near the second joint, where two bones move it.
  VertexId place = 0;
  for (const VertexId id : bar.model->surface().vertex_ids)
    if (std::abs((*bar.model->vertex(id)).rest.x() - 0.4) < 1e-9) place = id;
  const Vector3d force(3.0, -2.0, 5.0);
  ASSERT_TRUE(body.apply_force(place, force, 1000));
  double worked = 0.0;
  for (int k = 0; k < 50; ++k) {
    const Vector3d before = *body.position(place);
    ASSERT_TRUE(body.step().converged);
    worked += force.dot(*body.position(place) - before);
  }
  EXPECT_GT(std::abs(worked), 1e-4);
  EXPECT_NEAR(body.sums().work, worked, 1e-12 * std::abs(worked) + 1e-14);
}

TEST(Skeleton, WeightsByDistanceSumToOneAndAreSmooth) {
  const std::vector<BoneSegment> bones = bar_bones();
  std::vector<Vector3d> points;
  constexpr int kPoints = 6001;
  for (int k = 0; k < kPoints; ++k) points.emplace_back(1e-4 * k, 0.02, 0.1);
  const BoneWeights weights = weights_near(points, bones, 0.08);
  EXPECT_TRUE(weights_problem(weights).empty());
  double steepest = 0.0;
  for (Eigen::Index k = 1; k < weights.rows(); ++k) {
    EXPECT_NEAR(weights.row(k).sum(), 1.0, 1e-15);
    steepest = std::max(steepest, (weights.row(k) - weights.row(k - 1)).cwiseAbs().maxCoeff());
  }
  EXPECT_LE(steepest, 3e-3);
  EXPECT_EQ(weights(0, 0), 1.0);
  EXPECT_EQ(weights(kPoints - 1, 2), 1.0);
  EXPECT_NEAR(weights(2000, 0), 0.5, 1e-12);
}

TEST(Skeleton, WeightsOfTheNearestPointAreFound) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const auto cloud = [&](int count) {
    std::vector<Vector3d> points;
    for (int k = 0; k < count; ++k)
      points.emplace_back(uniform(generator), uniform(generator), uniform(generator));
    return points;
  };
  const std::vector<Vector3d> known = cloud(200), points = cloud(300);
  const BoneWeights numbers = VectorXd::LinSpaced(200, 0.0, 199.0);
  const BoneWeights found = weights_of_nearest(points, known, numbers);
  for (std::size_t p = 0; p < points.size(); ++p) {
    std::size_t best = 0;
    for (std::size_t k = 1; k < known.size(); ++k)
      if ((known[k] - points[p]).norm() < (known[best] - points[p]).norm()) best = k;
    EXPECT_EQ(found(static_cast<Eigen::Index>(p), 0), static_cast<double>(best));
  }
}

TEST(Skeleton, GivenWeightsAreTakenAndThoseThatAreNoneTold) {
  const RiggedBar bar = rigged_bar(3);
  const auto n = std::ssize(bar.model->drawn().rest);
  BoneWeights weights = weights_near(bar.model->drawn().rest, bar_bones(), 0.08);
  const auto skin = skin_of_weights(*bar.model, weights);
  ASSERT_TRUE(skin) << skin.error().message;
  EXPECT_LE(((*skin)->drawn - weights).norm(), 1e-14);
  const auto why = [&](const BoneWeights& wrong) {
    const auto refused = skin_of_weights(*bar.model, wrong);
    EXPECT_FALSE(refused);
    return refused ? std::string() : refused.error().message;
  };
  const auto expect_in = [](const std::string& text, const std::string& words) {
    EXPECT_NE(text.find(words), std::string::npos) << text;
  };
  expect_in(why(weights.topRows(n - 1)), "there are weights of " + std::to_string(n - 1));
  weights(4, 0) += 0.5;
  expect_in(why(weights), "row 5: the weights sum to 1.5, must sum to 1");
  weights(4, 0) = -0.25;
  expect_in(why(weights), "row 5: a weight is -0.25");
  weights(4, 0) = NAN;
  expect_in(why(weights), "row 5: a weight is not finite");
}

TEST(Skeleton, RefusesWhatItCannotBe) {
  const RiggedBar bar = rigged_bar(3);
  const auto expect_in = [](const std::string& text, const std::string& words) {
    EXPECT_NE(text.find(words), std::string::npos) << text;
  };
  BasisData data = bar.data;
  data.elements = {};
  const Model::Pointer without = *Model::from_data(data);
  expect_in(skin_near_bones(*without, bar_bones(), 0.1).error().message, "--keep-elements");
  EXPECT_TRUE(skin_near_bones(*without, std::vector{bar_bones()[0]}, 0.1));
  data = bar.data;
  data.inertia->linear *= 1.1;  // as if a point weighed more
  const Model::Pointer heavier = *Model::from_data(data);
  expect_in(skin_near_bones(*heavier, bar_bones(), 0.1).error().message, "point masses");
  EXPECT_FALSE(skin_near_bones(*bar.model, {}, 0.1));
  EXPECT_FALSE(skin_near_bones(*bar.model, bar_bones(), 0.0));
  const Model::Pointer other = testing::frame_model(3, false, 14.0, 90.0);
  expect_in(ContactBody::create(other, "ep4", {}, bar_skin(bar)).error().message, "another model");
  EXPECT_FALSE(ContactBody::create(bar.model, "verlet", {.step = 1e-4}, bar_skin(bar)));
  ContactBody body = make_rigged(bar.model, bar_skin(bar), {});
  EXPECT_FALSE(body.set_pose({}, 3));
  EXPECT_FALSE(body.move_to({{NAN, 0.0, 0.0}, {}}, std::nullopt, 0));
  EXPECT_FALSE(body.move_to({{}, Eigen::Quaterniond(2.0, 0.0, 0.0, 0.0)}, std::nullopt, 0));
  EXPECT_EQ(body.bones(), 3U);
  ContactBody driven = make_framed(other, FrameKind::kDriven, {});
  EXPECT_EQ(driven.bones(), 0U);
  EXPECT_FALSE(driven.set_pose({}, 0));
}

}  // namespace
}  // namespace tremolo
