#include "runtime/bodies/lanes/lane_force.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "common/packed_index.h"
#include "runtime/math/kernels/potential.h"
#include "tests/support/sample_basis.h"

namespace tremolo {
namespace {

using testing::random_vector;

template <class Real>
struct alignas(64) Row {
  Real value[kBodiesPerBlock<Real>];
};

// grad (C + Q) and C + Q of a block of states, by the lanes.
template <class Real>
struct LaneResult {
  std::vector<Eigen::VectorXd> gradients;
  std::vector<double> energies;
};

template <class Real>
LaneResult<Real> by_lanes(const LaneCoefficients<Real>& lanes,
                          const std::vector<Eigen::VectorXd>& states,
                          InstructionSet vectors = instruction_set()) {
  std::vector<Row<Real>> x(lanes.modes), gradient(lanes.modes), energy(1);
  for (std::size_t i = 0; i < lanes.modes; ++i)
    for (std::size_t lane = 0; lane < states.size(); ++lane)
      x[i].value[lane] = static_cast<Real>(states[lane][i] / lanes.coordinate_scale);
  evaluate_lanes(lanes, x[0].value, gradient[0].value, energy[0].value, vectors);
  // The gradient does not depend on whether the energy is requested, except for multiply-adds that
  // the compiler fuses differently.
  Real largest = 0;
  for (const Row<Real>& row : gradient)
    for (const Real value : row.value) largest = std::max(largest, std::abs(value));
  const Real rounding = 256 * std::numeric_limits<Real>::epsilon() * largest;
  std::vector<Row<Real>> again(lanes.modes);
  evaluate_lanes(lanes, x[0].value, again[0].value, static_cast<Real*>(nullptr), vectors);
  LaneResult<Real> result;
  for (std::size_t lane = 0; lane < states.size(); ++lane) {
    Eigen::VectorXd g(lanes.modes);
    for (std::size_t i = 0; i < lanes.modes; ++i) {
      EXPECT_NEAR(gradient[i].value[lane], again[i].value[lane], rounding);
      g[i] = lanes.energy_scale / lanes.coordinate_scale *
             static_cast<double>(gradient[i].value[lane]);
    }
    result.gradients.push_back(g);
    result.energies.push_back(lanes.energy_scale * static_cast<double>(energy[0].value[lane]));
  }
  return result;
}

BasisData basis_of(Eigen::Index r, double nonlinearity = 0.3) {
  return testing::sample_basis(
      testing::random_strain_model(testing::spread_omega(r, 10.0, 1000.0), nonlinearity, 11));
}

Evaluation evaluate(const Potential& potential, const Eigen::VectorXd& q) {
  PotentialWorkspace workspace = potential.make_workspace();
  Evaluation evaluation = potential.make_evaluation();
  potential.evaluate(q, kWantEnergy | kWantForce, workspace, evaluation);
  return evaluation;
}

std::vector<double> sizes(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return values;
}

// Compares with Potential, row by row, relative to the sum of the sizes of the row's terms (which
// the potential of absolute coefficients at |q| gives). Returns the largest such error.
template <class Real>
double largest_error(const BasisData& data, double amplitude,
                     InstructionSet vectors = instruction_set()) {
  const Eigen::Index r = data.lambda.size();
  const Potential potential = *Potential::create(data.lambda, data.cubic, data.quartic);
  const Potential absolute =
      *Potential::create(data.lambda, sizes(data.cubic), sizes(data.quartic));
  const auto lanes =
      make_lane_coefficients<Real>(static_cast<std::size_t>(r), data.cubic, data.quartic);
  std::vector<Eigen::VectorXd> states;
  for (unsigned lane = 0; lane < kBodiesPerBlock<Real>; ++lane)
    states.push_back(random_vector(r, amplitude, 3 + lane));
  const LaneResult<Real> result = by_lanes(lanes, states, vectors);
  double most = 0.0;
  for (std::size_t lane = 0; lane < states.size(); ++lane) {
    const Eigen::VectorXd& q = states[lane];
    const Eigen::VectorXd linear = data.lambda.cwiseProduct(q);
    const Evaluation expected = evaluate(potential, q);
    const Evaluation terms = evaluate(absolute, q.cwiseAbs());
    const Eigen::VectorXd difference = result.gradients[lane] + linear - expected.force;
    most = std::max(most, difference.cwiseAbs().cwiseQuotient(terms.force).maxCoeff());
    const double energy = result.energies[lane] + 0.5 * q.dot(linear);
    most = std::max(most, std::abs(energy - expected.energy) / terms.energy);
  }
  return most;
}

class LaneForceSize : public ::testing::TestWithParam<int> {};
// Every width of the kernel's inner loop, and remainders of each.
INSTANTIATE_TEST_SUITE_P(Sizes, LaneForceSize,
                         ::testing::Values(1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 12, 13, 15, 20, 30));

TEST_P(LaneForceSize, DoubleLanesEqualThePotential) {
  // Both sides round sums of up to r^3/36 = 750 parts; these errors do not all have one sign.
  EXPECT_LE(largest_error<double>(basis_of(GetParam()), 0.5), 1e-14);
}

TEST_P(LaneForceSize, FloatLanesEqualThePotentialToFloatRounding) {
  // eps = 6e-8 of the coefficients, of q and of every operation: a few eps of the terms' sizes.
  EXPECT_LE(largest_error<float>(basis_of(GetParam()), 0.5), 5e-7);
}

TEST(LaneForce, NarrowerVectorsGiveTheSameToRounding) {
  for (const InstructionSet vectors : {InstructionSet::kPlain, InstructionSet::kAvx2}) {
    if (vectors > instruction_set()) continue;
    EXPECT_LE(largest_error<double>(basis_of(11), 0.5, vectors), 1e-14);
    EXPECT_LE(largest_error<float>(basis_of(11), 0.5, vectors), 5e-7);
  }
}

TEST(LaneForce, FloatRangeIsNoQuestionOfUnits) {
  // Quartic coefficients of 1e40 and states of 1e-16: neither is a number in float.
  EXPECT_LE(largest_error<float>(basis_of(8, 0.3e17), 0.5e-17), 5e-7);
  EXPECT_LE(largest_error<float>(basis_of(8, 0.3e-17), 0.5e17), 5e-7);
}

TEST(LaneForce, ABodysResultDependsOnNeitherItsLaneNorItsNeighbours) {
  const BasisData data = basis_of(9);
  const auto lanes = make_lane_coefficients<float>(9, data.cubic, data.quartic);
  const Eigen::VectorXd q = random_vector(9, 0.4, 1);
  std::vector<Eigen::VectorXd> alone(kBodiesPerBlock<float>, Eigen::VectorXd::Zero(9));
  alone[0] = q;
  const LaneResult<float> reference = by_lanes(lanes, alone);
  for (std::size_t at = 0; at < kBodiesPerBlock<float>; ++at) {
    std::vector<Eigen::VectorXd> states;
    for (unsigned lane = 0; lane < kBodiesPerBlock<float>; ++lane)
      states.push_back(lane == at ? q : random_vector(9, 1e3, 50 + lane));
    const LaneResult<float> result = by_lanes(lanes, states);
    EXPECT_EQ(result.gradients[at], reference.gradients[0]);
    EXPECT_EQ(result.energies[at], reference.energies[0]);
  }
}

TEST(LaneForce, ModelWithoutCubicOrQuarticTermsIsFine) {
  for (const bool cubic : {false, true})
    for (const bool quartic : {false, true}) {
      BasisData data = basis_of(5);
      if (!cubic) std::fill(data.cubic.begin(), data.cubic.end(), 0.0);
      if (!quartic) std::fill(data.quartic.begin(), data.quartic.end(), 0.0);
      EXPECT_LE(largest_error<double>(data, 0.5), 1e-14) << cubic << quartic;
      EXPECT_LE(largest_error<float>(data, 0.5), 5e-7) << cubic << quartic;
    }
}

TEST(LaneForce, FewerModesAreThePotentialWithTheOthersAtZero) {
  const BasisData data = basis_of(12);
  BasisData fewer = data;
  fewer.lambda = data.lambda.head(7);
  EXPECT_LE(largest_error<double>(fewer, 0.5), 1e-14);
}

}  // namespace
}  // namespace tremolo
