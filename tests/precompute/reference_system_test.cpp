// The unreduced body's energy, mean force and tangent, and its reduced counterpart's, against what
// defines them.
#include <numbers>

#include <gtest/gtest.h>

#include "common/energy.h"
#include "common/load_signal.h"
#include "precompute/problem/rigid_motion.h"
#include "precompute/reference/reduced_model.h"
#include "precompute/reference/time_integration.h"
#include "tests/support/reference_body.h"

namespace tremolo {
namespace {

using testing::bar_problem;
using testing::ReferenceBody;

const auto kMean = segment_points(TimeScheme::kAveragedField);

class ReferenceElements : public ::testing::TestWithParam<bool> {
 protected:
  ReferenceBody bar_{bar_problem(GetParam() ? testing::wood() : Material{2e5, 0.4, 1000.0})};
};

TEST_P(ReferenceElements, MeanForceDottedWithTheStepIsTheEnergyDifference) {
  const Vector u = bar_.random(0.03, 1), d = bar_.random(0.05, 2);
  const double difference = potential_energy(bar_.body, u + d) - potential_energy(bar_.body, u);
  const double work = segment_force(bar_.body, kMean, u, d).dot(d);
  EXPECT_NEAR(work, difference, 1e-13 * potential_energy(bar_.body, u + d));  // rounding
}

TEST_P(ReferenceElements, ForceAtAPointIsThatOfTheElements) {
  const Vector u = bar_.random(0.03, 3);
  const Vector force = segment_force(bar_.body, {{1.0, 1.0}}, Vector::Zero(u.size()), u);
  const Field expected = internal_force(bar_.body.solid, expand(bar_.body.unknowns, u));
  EXPECT_LE((force - restrict_to(bar_.body.unknowns, expected)).norm(), 1e-14 * expected.norm());
}

TEST_P(ReferenceElements, TangentIsTheDerivativeOfTheMeanForceAndSymmetric) {
  const Vector u = bar_.random(0.03, 4), d = bar_.random(0.05, 5), along = bar_.random(0.05, 6);
  std::vector<double> tangent;
  segment_tangent(bar_.body, kMean, u, d, tangent);
  const Vector image = multiply(bar_.body, tangent, along);
  // The force is cubic: the central difference errs by c e^2, which halving e takes out.
  const auto difference = [&](double e) -> Vector {
    return (segment_force(bar_.body, kMean, u, d + e * along) -
            segment_force(bar_.body, kMean, u, d - e * along)) /
           (2 * e);
  };
  const Vector exact = (4.0 * difference(0.05) - difference(0.1)) / 3.0;
  EXPECT_LE((image - exact).norm(), 1e-12 * image.norm());
  const Vector other = bar_.random(1.0, 7);
  EXPECT_NEAR(other.dot(image), along.dot(multiply(bar_.body, tangent, other)),
              1e-12 * other.norm() * image.norm());
}

TEST_P(ReferenceElements, SumsDoNotDependOnTheNumberOfThreads) {
  const Problem same = bar_problem(GetParam() ? testing::wood() : Material{2e5, 0.4, 1000.0});
  const ReferenceBody other(same, MassKind::kConsistent, 3);
  const Vector u = bar_.random(0.03, 8), d = bar_.random(0.05, 9);
  EXPECT_EQ(segment_force(bar_.body, kMean, u, d), segment_force(other.body, kMean, u, d));
  std::vector<double> a, b;
  segment_tangent(bar_.body, kMean, u, d, a);
  segment_tangent(other.body, kMean, u, d, b);
  EXPECT_EQ(a, b);
}

INSTANTIATE_TEST_SUITE_P(Materials, ReferenceElements, ::testing::Values(false, true),
                         [](const auto& material) { return material.param ? "Wood" : "Rubber"; });

TEST(ReferenceSystem, MassAndWeightAreThoseOfTheBody) {
  Problem problem = testing::box_problem({2, 2, 2}, {0.2, 0.3, 0.5}, {1e5, 0.3, 1200.0});
  problem.free_body = true;
  problem.point_masses.push_back({"", 2.5, {0, 3}, 0});
  for (MassKind kind : {MassKind::kConsistent, MassKind::kLumped}) {
    const ReferenceBody box(problem, kind);
    const double mass = 1200.0 * 0.03 + 2.5;
    Vector unit = Vector::Zero(box.body.size());
    for (Eigen::Index i = 0; i < unit.size(); ++i)
      unit[i] = box.body.unknowns.dof[i] % 3 == 1 ? 1.0 : 0.0;
    EXPECT_NEAR(unit.dot(multiply(box.body, box.body.mass, unit)), mass, 1e-12 * mass);
    EXPECT_NEAR(gravity_load(box.body, {1, -9.81, 3}).dot(unit), -9.81 * mass, 1e-12 * mass);
  }
}

TEST(ReferenceSystem, HeldComponentsAreNoUnknowns) {
  Problem problem = bar_problem();
  problem.held[2] = {6, 7};
  const ReferenceBody bar(problem);
  const ReferenceBody without(bar_problem());
  EXPECT_EQ(bar.body.size(), without.body.size() - 2);
  EXPECT_EQ(bar.body.unknowns.of_dof[3 * 7 + 2], -1);
  EXPECT_GE(bar.body.unknowns.of_dof[3 * 7 + 1], 0);
  // The rest is the same matrix with two rows and columns removed.
  const Vector x = bar.random(1.0, 1);
  const Vector wide = restrict_to(without.body.unknowns, expand(bar.body.unknowns, x));
  const auto image = [](const ReferenceBody& of, const Vector& v) {
    return expand(of.body.unknowns, multiply(of.body, of.body.stiffness, v));
  };
  Vector expected = image(without, wide);
  expected[3 * 6 + 2] = expected[3 * 7 + 2] = 0;
  EXPECT_LE((image(bar, x) - expected).norm(), 1e-14 * expected.norm());
}

TEST(ReferenceSystem, HoldingAxesCountsAgainstRigidFreedom) {
  const TetMesh mesh = testing::box_mesh({1, 1, 1}, {1, 1, 1});
  const std::vector<int> part(mesh.vertices.size(), 0);
  std::array<std::vector<VertexId>, 3> held;
  for (VertexId v = 0; v < 8; ++v) held[2].push_back(v);
  EXPECT_EQ(rigid_freedom(mesh, part, 1, {}, held).front(), 3);  // x, y and turning about z
  held[0] = {0};
  held[1] = {0};
  EXPECT_EQ(rigid_freedom(mesh, part, 1, {}, held).front(), 1);
  held[1] = {0, 1};
  EXPECT_EQ(rigid_freedom(mesh, part, 1, {}, held).front(), 0);
}

// A random model with positive quartic growth.
struct ChanceModel {
  Vector lambda{{1.0, 4.0, 9.0, 30.0}};
  std::vector<double> cubic, quartic;
  ChanceModel() {
    std::mt19937 engine(5);
    std::uniform_real_distribution<double> uniform(-0.3, 0.3);
    for (int i = 0; i < 20; ++i) cubic.push_back(uniform(engine));
    for (int i = 0; i < 35; ++i) quartic.push_back(uniform(engine));
  }
};

TEST(ReferenceReducedModel, ForceEnergyAndTangentAreThoseOfThePolynomial) {
  const ChanceModel chance;
  const ReducedModel model = make_reduced_model(chance.lambda, chance.cubic, chance.quartic);
  const Vector q{{0.4, -0.7, 0.2, 0.5}}, d{{-0.3, 0.1, 0.9, -0.4}}, zero = Vector::Zero(4);
  const Vector force = reduced_force(model, {{1.0, 1.0}}, zero, q);
  EXPECT_LE((force - reduced_energy(chance.lambda, chance.cubic, chance.quartic, q).force).norm(),
            1e-14 * force.norm());
  EXPECT_NEAR(reduced_force(model, kMean, q, d).dot(d),
              reduced_energy(model, q + d) - reduced_energy(model, q), 1e-14);
  const Eigen::MatrixXd tangent = reduced_tangent(model, kMean, q, d);
  for (Eigen::Index i = 0; i < 4; ++i) {
    const auto difference = [&](double e) -> Vector {
      const Vector step = e * Vector::Unit(4, i);
      return (reduced_force(model, kMean, q, d + step) - reduced_force(model, kMean, q, d - step)) /
             (2 * e);
    };
    const Vector exact = (4.0 * difference(0.05) - difference(0.1)) / 3.0;
    EXPECT_LE((tangent.col(i) - exact).norm(), 1e-12 * tangent.norm());
  }
}

TEST(ReferenceReducedModel, TheFirstCoordinatesAreTheModelWithTheOthersAtZero) {
  const ChanceModel chance;
  const ReducedModel model = make_reduced_model(chance.lambda, chance.cubic, chance.quartic);
  const ReducedModel first = first_coordinates(model, 2);
  const Vector q{{0.4, -0.7, 0.0, 0.0}}, zero = Vector::Zero(4);
  EXPECT_DOUBLE_EQ(reduced_energy(first, q.head(2)), reduced_energy(model, q));
  const Vector short_force = reduced_force(first, {{1.0, 1.0}}, zero.head(2), q.head(2));
  EXPECT_LE((short_force - reduced_force(model, {{1.0, 1.0}}, zero, q).head(2)).norm(), 1e-15);
}

TEST(ReferenceLoad, EveryStepHandsOnTheSameImpulse) {
  const auto impulse = [](SignalKind kind, double step, double until) {
    double sum = 0;
    const int steps = static_cast<int>(std::lround(until / step));
    for (int k = 0; k < steps; ++k)
      sum += step * sample_signal({.kind = kind}, k * step, step).average;
    return sum;
  };
  for (const double step : {1e-2, 3e-3, 7e-4}) {
    EXPECT_NEAR(impulse(SignalKind::kImpulse, step, 0.42), 3e-3, 1e-15);
    EXPECT_NEAR(impulse(SignalKind::kSquare, step, 0.42), 0.3, 1e-13);
    EXPECT_NEAR(impulse(SignalKind::kSine, step, 0.42),
                (1 - std::cos(2 * std::numbers::pi * 0.42)) / (2 * std::numbers::pi), 1e-13);
    EXPECT_EQ(impulse(SignalKind::kNone, step, 0.42), 0.0);
  }
}

TEST(ReferenceLine, TheFirstMinimumOfAQuarticIsFound) {
  // Slopes (t - a)(t - b)(t - c), negative at 0: the first root is a minimum.
  for (const auto& [a, b, c] :
       {std::array{0.3, 0.9, 2.0}, std::array{0.02, 0.8, 0.9}, std::array{1.7, 5.0, 8.0}}) {
    const auto slope = [&](double t) { return (t - a) * (t - b) * (t - c); };
    const double curvature = a * b + b * c + c * a;
    EXPECT_NEAR(first_minimum(slope(0), curvature, slope(0.5), slope(1), 16.0), a, 1e-12);
  }
  // Downhill all the way: as far as allowed.
  EXPECT_EQ(first_minimum(-1.0, -1.0, -1.5, -2.0, 16.0), 16.0);
}

}  // namespace
}  // namespace tremolo
