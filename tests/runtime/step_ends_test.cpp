// What an energy-preserving step knows of its ends, against the same by other formulas.
#include "runtime/bodies/reduced/integrators/solve/step_ends.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/sample_basis.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

class StepEndsTest : public ::testing::TestWithParam<Index> {
 protected:
  StepEndsTest()
      : basis_(testing::sample_basis(
            testing::random_strain_model(testing::spread_omega(r_, 1.0, 100.0), 0.3, 11))),
        potential_(*Potential::create(basis_.lambda, basis_.cubic, basis_.quartic)),
        workspace_(potential_.make_workspace()),
        q0_(testing::random_vector(r_, 0.3, 1)),
        q1_(q0_ + testing::random_vector(r_, 0.01, 2)),
        x_(testing::random_vector(r_, 1e-5, 3)) {}

  VectorXd mean(const VectorXd& from, const VectorXd& to) {
    VectorXd G(r_);
    potential_.averaged_gradient(from, to, workspace_, G);
    return G;
  }
  double energy(const VectorXd& q) {
    Evaluation at = potential_.make_evaluation();
    potential_.evaluate(q, kWantEnergy, workspace_, at);
    return at.energy;
  }
  // The error of G after a move of the end, by `near` with another gradient or without, in the step
  // and in the next.
  struct Errors {
    double now, next;
  };
  Errors errors_after(const VectorXd& move, bool near) {
    StepEnds ends(potential_);
    VectorXd G(r_), bent(r_);
    ends.start_at(q0_);
    ends.end_at(q1_, q1_ - q0_, G);
    const VectorXd moved = q1_ + move, q2 = moved + 0.7 * (q1_ - q0_);
    if (near)
      ends.end_near(move, moved, moved - q0_, G);
    else
      ends.move_end(move, moved, G, bent);
    const double now = (G - mean(q0_, moved)).norm();
    EXPECT_NEAR(ends.work(), energy(moved) - energy(q0_), 1e-12 * std::abs(ends.work()));
    ends.accept(moved);
    EXPECT_EQ(ends.known_energy(moved), ends.start().energy);
    EXPECT_FALSE(ends.known_energy(q1_));
    ends.start_at(moved);
    ends.end_at(q2, q2 - moved, G);
    return {now, (G - mean(moved, q2)).norm()};
  }

  Index r_ = GetParam();
  BasisData basis_;
  Potential potential_;
  PotentialWorkspace workspace_;
  VectorXd q0_, q1_, x_;
};

TEST_P(StepEndsTest, GiveTheMeanForceItsDerivativeAndTheMeanTangent) {
  StepEnds ends(potential_);
  VectorXd G(r_), expected(r_);
  MatrixXd K(r_, r_), expected_K(r_, r_);
  ends.start_at(q0_);
  ends.end_at(q1_, q1_ - q0_, G);
  ends.mean_tangent(K);
  potential_.averaged_gradient(q0_, q1_, workspace_, expected, &expected_K);
  EXPECT_LT((G - expected).norm(), 1e-13 * expected.norm());
  EXPECT_LT((K - expected_K).norm(), 1e-13 * expected_K.norm());
  ends.mean_derivative(0.5 * (q0_ + q1_), K);
  potential_.averaged_jacobian(q0_, q1_, workspace_, expected_K);
  EXPECT_LT((K - expected_K).norm(), 1e-13 * expected_K.norm());
  EXPECT_NEAR(ends.work(), G.dot(q1_ - q0_), 1e-12 * std::abs(ends.work()));
}

// What a move leaves in G is of second order in it, or first in it and second in d: the error of a
// tangent that is merely old, first in both, is ten times as large and more.
TEST_P(StepEndsTest, FollowASmallMoveOfTheEnd) {
  Evaluation before = potential_.make_evaluation(), after = before;
  potential_.evaluate(q1_, kWantTangent, workspace_, before);
  potential_.evaluate(q1_ + x_, kWantTangent, workspace_, after);
  const double old = ((after.tangent - before.tangent) * (q1_ - q0_)).norm() / 12.0;
  for (const bool near : {true, false}) {
    const Errors whole = errors_after(x_, near), half = errors_after(0.5 * x_, near);
    EXPECT_LT(whole.now, 0.1 * old) << near;
    EXPECT_LT(whole.next, 0.1 * old) << near;
    EXPECT_LT(half.now, 0.6 * whole.now + 1e-12) << near;
    EXPECT_LT(half.next, 0.6 * whole.next + 1e-12) << near;
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, StepEndsTest, ::testing::Values(4, 24));

}  // namespace
}  // namespace tremolo
