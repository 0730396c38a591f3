// The consistency checks of every potential.
#pragma once

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "runtime/math/kernels/potential.h"

namespace tremolo::testing {

// Central differences of step s and 2s, combined: (4 D(s) - D(2s))/3 has no truncation error for
// polynomials up to degree four, so any step will do and only rounding remains.
template <class Function>
auto exact_derivative(Function&& f, double s) {
  using Value = decltype(f(s));
  const Value near = (f(s) - f(-s)) / (2.0 * s);
  const Value far = (f(2.0 * s) - f(-2.0 * s)) / (4.0 * s);
  return Value((4.0 * near - far) / 3.0);
}

// Calls check(i, here, d) for each coordinate i: `here` is the evaluation at q of what `at_q`
// wants, d the derivative with respect to q_i of part(evaluation) of what `nearby` wants.
template <class Wanted, class Part, class Check>
void for_each_derivative(const Potential& potential, const Eigen::VectorXd& q, Wanted at_q,
                         Wanted nearby, const Part& part, const Check& check) {
  PotentialWorkspace workspace = potential.make_workspace();
  Evaluation here = potential.make_evaluation();
  Evaluation there = potential.make_evaluation();
  potential.evaluate(q, at_q, workspace, here);
  const double step = 0.25 * q.cwiseAbs().maxCoeff();
  for (Eigen::Index i = 0; i < q.size(); ++i)
    check(i, here,
          exact_derivative(
              [&](double s) {
                Eigen::VectorXd moved = q;
                moved[i] += s;
                potential.evaluate(moved, nearby, workspace, there);
                return part(there);
              },
              step));
}

// dV/dq_i = R_i at q, relative to the largest component.
inline void check_force_is_gradient(const Potential& potential, const Eigen::VectorXd& q,
                                    double tolerance) {
  for_each_derivative(
      potential, q, kWantForce, kWantEnergy, [](const Evaluation& at) { return at.energy; },
      [&](Eigen::Index i, const Evaluation& here, double derivative) {
        EXPECT_NEAR(derivative, here.force[i], tolerance * here.force.cwiseAbs().maxCoeff())
            << "coordinate " << i;
      });
}

// dR/dq_i = column i of K at q, relative to the largest entry.
inline void check_tangent_is_force_derivative(const Potential& potential, const Eigen::VectorXd& q,
                                              double tolerance) {
  for_each_derivative(
      potential, q, kWantTangent, kWantForce,
      [](const Evaluation& at) { return Eigen::VectorXd(at.force); },
      [&](Eigen::Index i, const Evaluation& here, const Eigen::VectorXd& derivative) {
        EXPECT_LE((derivative - here.tangent.col(i)).cwiseAbs().maxCoeff(),
                  tolerance * here.tangent.cwiseAbs().maxCoeff())
            << "coordinate " << i;
      });
}

}  // namespace tremolo::testing
