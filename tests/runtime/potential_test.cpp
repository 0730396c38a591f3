#include "runtime/math/kernels/potential.h"

#include <gtest/gtest.h>

#include "tests/support/potential_checks.h"
#include "tests/support/sample_basis.h"

namespace tremolo {
namespace {

using testing::random_vector;

// Frequencies over two decades, so that a wrong index shows.
testing::StrainModel wide_strain_model(Eigen::Index r) {
  return testing::random_strain_model(testing::spread_omega(r, 10.0, 1000.0), 0.3, 11);
}

Potential make_potential(Eigen::Index r) {
  const BasisData data = testing::sample_basis(wide_strain_model(r));
  Result<Potential> potential = Potential::create(data.lambda, data.cubic, data.quartic);
  EXPECT_TRUE(potential);
  return *potential;
}

class PotentialSize : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Sizes, PotentialSize,
                         ::testing::Values(1, 2, 3, 4, 5, 7, 8, 9, 15, 16, 20, 24, 30, 33));

TEST_P(PotentialSize, KernelEqualsTheSumOverAllIndices) {
  const std::size_t r = GetParam();
  const BasisData data = testing::sample_basis(wide_strain_model(GetParam()));
  const Eigen::VectorXd q = random_vector(GetParam(), 0.5, 3);
  const auto at = [&](std::size_t i) { return q[i]; };
  double energy = 0.0, magnitude = 0.0;
  Eigen::VectorXd force = data.lambda.cwiseProduct(q);
  for (std::size_t i = 0; i < r; ++i) {
    energy += 0.5 * data.lambda[i] * at(i) * at(i);
    for (std::size_t j = 0; j < r; ++j)
      for (std::size_t k = 0; k < r; ++k) {
        const double c = data.cubic[triple_index_any(i, j, k)] * at(j) * at(k);
        energy += c * at(i);
        force[i] += 3.0 * c;
        for (std::size_t l = 0; l < r; ++l) {
          const double t = data.quartic[quad_index_any(i, j, k, l)] * at(j) * at(k) * at(l);
          energy += t * at(i);
          magnitude += std::abs(t * at(i));
          force[i] += 4.0 * t;
        }
      }
  }
  const Potential potential = make_potential(GetParam());
  PotentialWorkspace workspace = potential.make_workspace();
  Evaluation evaluation = potential.make_evaluation();
  potential.evaluate(q, kWantEnergy | kWantForce, workspace, evaluation);
  // Rounding of sums of up to r^4 = 1.2 million terms, relative to the sum of their sizes.
  EXPECT_NEAR(evaluation.energy, energy, 1e-13 * (energy + magnitude));
  EXPECT_LE((evaluation.force - force).norm(), 1e-13 * (force.norm() + magnitude));
}

TEST_P(PotentialSize, EqualsTheStrainEnergyItWasExpandedFrom) {
  const testing::StrainModel model = wide_strain_model(GetParam());
  const Potential potential = make_potential(GetParam());
  PotentialWorkspace workspace = potential.make_workspace();
  Evaluation evaluation = potential.make_evaluation();
  for (unsigned seed = 1; seed < 5; ++seed) {
    const Eigen::VectorXd q = random_vector(GetParam(), 0.3 * seed, seed);
    potential.evaluate(q, kWantEnergy | kWantForce, workspace, evaluation);
    // Rounding only; the expansion itself cancels a digit or two.
    const double energy = testing::strain_energy(model, q);
    const Eigen::VectorXd force = testing::strain_force(model, q);
    EXPECT_NEAR(evaluation.energy, energy, 1e-12 * energy);
    EXPECT_LE((evaluation.force - force).norm(), 1e-12 * force.norm());
  }
}

TEST_P(PotentialSize, ForceIsTheGradientOfTheEnergy) {
  // Differences of a quartic without truncation error: rounding of about 1e-15 times a few hundred.
  testing::check_force_is_gradient(make_potential(GetParam()), random_vector(GetParam(), 0.4, 5),
                                   1e-12);
}

TEST_P(PotentialSize, TangentIsTheDerivativeOfTheForce) {
  testing::check_tangent_is_force_derivative(make_potential(GetParam()),
                                             random_vector(GetParam(), 0.4, 6), 1e-12);
}

TEST_P(PotentialSize, TangentIsSymmetricToTheLastBit) {
  const Potential potential = make_potential(GetParam());
  PotentialWorkspace workspace = potential.make_workspace();
  Evaluation evaluation = potential.make_evaluation();
  potential.evaluate(random_vector(GetParam(), 0.4, 6), kWantTangent, workspace, evaluation);
  EXPECT_EQ(evaluation.tangent, evaluation.tangent.transpose());
}

TEST_P(PotentialSize, LeadingPotentialIsTheOneMadeOfTheLeadingCoordinates) {
  const Eigen::Index r = GetParam();
  const BasisData data = testing::sample_basis(wide_strain_model(r));
  const Potential full = make_potential(r);
  for (Eigen::Index kept = 1; kept <= r; ++kept) {
    const Result<Potential> made =
        Potential::create(data.lambda.head(kept), data.cubic, data.quartic);
    ASSERT_TRUE(made);
    const Potential part = full.leading(kept);
    ASSERT_EQ(part.size(), kept);
    PotentialWorkspace workspace = part.make_workspace();
    Evaluation a = part.make_evaluation(), b = part.make_evaluation();
    const Eigen::VectorXd q = random_vector(kept, 0.4, 8);
    constexpr unsigned kAll = kWantEnergy | kWantForce | kWantTangent;
    part.evaluate(q, kAll, workspace, a);
    made->evaluate(q, kAll, workspace, b);
    // The same numbers in the same order.
    EXPECT_EQ(a.energy, b.energy);
    EXPECT_EQ(a.force, b.force);
    EXPECT_EQ(a.tangent, b.tangent);
  }
  EXPECT_EQ(full.leading(0).size(), 0);
}

TEST_P(PotentialSize, LeadingCoordinatesEqualZeroPadding) {
  const Eigen::Index r = GetParam();
  const BasisData data = testing::sample_basis(wide_strain_model(r));
  const Potential full = make_potential(r);
  PotentialWorkspace full_workspace = full.make_workspace();
  Evaluation full_evaluation = full.make_evaluation();
  for (Eigen::Index kept = 1; kept <= r; ++kept) {
    // The whole arrays are given: the leading coordinates' coefficients are their prefix.
    const Result<Potential> part =
        Potential::create(data.lambda.head(kept), data.cubic, data.quartic);
    ASSERT_TRUE(part);
    PotentialWorkspace workspace = part->make_workspace();
    Evaluation evaluation = part->make_evaluation();
    const Eigen::VectorXd q = random_vector(kept, 0.4, 8);
    Eigen::VectorXd padded = Eigen::VectorXd::Zero(r);
    padded.head(kept) = q;
    part->evaluate(q, kWantEnergy | kWantForce | kWantTangent, workspace, evaluation);
    full.evaluate(padded, kWantEnergy | kWantForce | kWantTangent, full_workspace, full_evaluation);
    // The same sums in another order.
    EXPECT_NEAR(evaluation.energy, full_evaluation.energy, 1e-13 * full_evaluation.energy);
    EXPECT_LE((evaluation.force - full_evaluation.force.head(kept)).norm(),
              1e-13 * full_evaluation.force.norm());
    EXPECT_LE((evaluation.tangent - full_evaluation.tangent.topLeftCorner(kept, kept)).norm(),
              1e-13 * full_evaluation.tangent.norm());
  }
}

TEST_P(PotentialSize, TrailingRowsEqualTheFullEvaluation) {
  const Eigen::Index r = GetParam();
  const Potential potential = make_potential(r);
  PotentialWorkspace workspace = potential.make_workspace();
  PotentialWorkspace full_workspace = potential.make_workspace();
  Evaluation part = potential.make_evaluation();
  Evaluation full = potential.make_evaluation();
  for (Eigen::Index held = 0; held <= r; ++held) {
    Eigen::VectorXd q = random_vector(r, 0.4, 9);
    potential.begin_trailing(q, held, workspace);
    for (unsigned seed = 20; seed < 23; ++seed) {
      q.tail(r - held) = random_vector(r - held, 0.4, seed);
      potential.evaluate_trailing(q, held, kWantForce | kWantTangent, workspace, part);
      potential.evaluate(q, kWantForce | kWantTangent, full_workspace, full);
      // The same sums in another order.
      EXPECT_LE((part.force - full.force).tail(r - held).norm(), 1e-13 * full.force.norm());
      EXPECT_LE((part.tangent - full.tangent).bottomRightCorner(r - held, r - held).norm(),
                1e-13 * full.tangent.norm());
    }
  }
}

TEST_P(PotentialSize, AveragedGradientEqualsGaussLegendre) {
  const Potential potential = make_potential(GetParam());
  PotentialWorkspace workspace = potential.make_workspace();
  Evaluation evaluation = potential.make_evaluation();
  const Eigen::VectorXd q0 = random_vector(GetParam(), 0.5, 12);
  const Eigen::VectorXd q1 = random_vector(GetParam(), 0.5, 13);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(GetParam());
  // Two points integrate the cubic force exactly.
  for (const double s : {0.5 - 0.5 / std::sqrt(3.0), 0.5 + 0.5 / std::sqrt(3.0)}) {
    potential.evaluate((1.0 - s) * q0 + s * q1, kWantForce, workspace, evaluation);
    sum += 0.5 * evaluation.force;
  }
  Eigen::VectorXd average = Eigen::VectorXd::Zero(GetParam());
  potential.averaged_gradient(q0, q1, workspace, average);
  EXPECT_LE((average - sum).norm(), 1e-13 * sum.norm() + 1e-13);
}

TEST_P(PotentialSize, AveragedGradientAlongTheSegmentIsTheEnergyDifference) {
  const Potential potential = make_potential(GetParam());
  PotentialWorkspace workspace = potential.make_workspace();
  Evaluation start = potential.make_evaluation();
  Evaluation end = potential.make_evaluation();
  const Eigen::VectorXd q0 = random_vector(GetParam(), 0.5, 14);
  const Eigen::VectorXd q1 = random_vector(GetParam(), 0.5, 15);
  potential.evaluate(q0, kWantEnergy, workspace, start);
  potential.evaluate(q1, kWantEnergy, workspace, end);
  Eigen::VectorXd average = Eigen::VectorXd::Zero(GetParam());
  potential.averaged_gradient(q0, q1, workspace, average);
  EXPECT_NEAR(average.dot(q1 - q0), end.energy - start.energy,
              1e-13 * (start.energy + end.energy));  // rounding
}

TEST_P(PotentialSize, TangentOfTheAveragedGradientIsTheMeanOfTheTangentsAtTheEnds) {
  // K is quadratic: (K(m + d) + K(m - d))/2 = K(m) + 12 Q[d d^T].
  const Potential potential = make_potential(GetParam());
  PotentialWorkspace workspace = potential.make_workspace();
  Evaluation start = potential.make_evaluation(), end = potential.make_evaluation();
  const Eigen::VectorXd q0 = random_vector(GetParam(), 0.5, 16);
  const Eigen::VectorXd q1 = random_vector(GetParam(), 0.5, 17);
  potential.evaluate(q0, kWantTangent, workspace, start);
  potential.evaluate(q1, kWantTangent, workspace, end);
  Eigen::VectorXd with = Eigen::VectorXd::Zero(GetParam()), without = with;
  Eigen::MatrixXd tangent = Eigen::MatrixXd::Zero(GetParam(), GetParam());
  potential.averaged_gradient(q0, q1, workspace, without);
  potential.averaged_gradient(q0, q1, workspace, with, &tangent);
  EXPECT_LE((with - without).norm(), 1e-13 * with.norm());  // large ones use another path
  EXPECT_EQ(tangent, tangent.transpose());
  const Eigen::MatrixXd mean = 0.5 * (start.tangent + end.tangent);
  EXPECT_LE((tangent - mean).norm(), 1e-13 * mean.norm());  // rounding
}

TEST(Potential, FillsOnlyWhatIsWanted) {
  const Potential potential = make_potential(3);
  PotentialWorkspace workspace = potential.make_workspace();
  Evaluation evaluation = potential.make_evaluation();
  evaluation.energy = -1.0;
  evaluation.tangent.setConstant(-2.0);
  potential.evaluate(random_vector(3, 0.4, 16), kWantForce, workspace, evaluation);
  EXPECT_EQ(evaluation.energy, -1.0);
  EXPECT_EQ(evaluation.tangent, Eigen::MatrixXd::Constant(3, 3, -2.0));
  EXPECT_NE(evaluation.force, Eigen::VectorXd::Zero(3));
}

TEST(Potential, RefusesArraysThatAreTooShort) {
  const BasisData data = testing::sample_basis(wide_strain_model(3));
  std::vector<double> shorter(data.quartic.begin(), data.quartic.end() - 1);
  const Result<Potential> potential = Potential::create(data.lambda, data.cubic, shorter);
  ASSERT_FALSE(potential);
  EXPECT_EQ(potential.error().kind, ErrorKind::kContent);
  EXPECT_NE(potential.error().message.find("found 10 and 14"), std::string::npos)
      << potential.error().message;
}

TEST(Potential, RefusesACoefficientThatIsNotFinite) {
  BasisData data = testing::sample_basis(wide_strain_model(3));
  data.cubic[4] = std::nan("");
  const Result<Potential> potential = Potential::create(data.lambda, data.cubic, data.quartic);
  ASSERT_FALSE(potential);
  EXPECT_NE(potential.error().message.find("cubic coefficient 4"), std::string::npos);
}

TEST(Potential, RefusesToHaveNoCoordinates) {
  EXPECT_FALSE(Potential::create(Eigen::VectorXd(), {}, {}));
}

}  // namespace
}  // namespace tremolo
