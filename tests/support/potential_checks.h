// The consistency checks that every potential has to pass, in one place.
#pragma once

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "runtime/kernels/potential.h"

namespace tremolo::testing {

// Central differences of step s and 2s, combined: (4 D(s) - D(2s))/3 has no truncation error for
// polynomials up to degree four, so any step will do and what is left is rounding.
template <class Function>
auto exact_derivative(Function&& f, double s) {
  using Value = decltype(f(s));
  const Value near = (f(s) - f(-s)) / (2.0 * s);
  const Value far = (f(2.0 * s) - f(-2.0 * s)) / (4.0 * s);
  return Value((4.0 * near - far) / 3.0);
}

// dV/dq_i = R_i at q, relative to the largest component.
inline void check_force_is_gradient(const Potential& potential, const Eigen::VectorXd& q,
                                    double tolerance) {
  PotentialWorkspace workspace = potential.make_workspace();
  Evaluation here = potential.make_evaluation();
  Evaluation there = potential.make_evaluation();
  potential.evaluate(q, kWantForce, workspace, here);
  const double step = 0.25 * q.cwiseAbs().maxCoeff();
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const double derivative = exact_derivative(
        [&](double s) {
          Eigen::VectorXd moved = q;
          moved[i] += s;
          potential.evaluate(moved, kWantEnergy, workspace, there);
          return there.energy;
        },
        step);
    EXPECT_NEAR(derivative, here.force[i], tolerance * here.force.cwiseAbs().maxCoeff())
        << "coordinate " << i;
  }
}

// dR/dq_i = column i of K at q, relative to the largest entry.
inline void check_tangent_is_force_derivative(const Potential& potential, const Eigen::VectorXd& q,
                                              double tolerance) {
  PotentialWorkspace workspace = potential.make_workspace();
  Evaluation here = potential.make_evaluation();
  Evaluation there = potential.make_evaluation();
  potential.evaluate(q, kWantTangent, workspace, here);
  const double step = 0.25 * q.cwiseAbs().maxCoeff();
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const Eigen::VectorXd derivative = exact_derivative(
        [&](double s) {
          Eigen::VectorXd moved = q;
          moved[i] += s;
          potential.evaluate(moved, kWantForce, workspace, there);
          return Eigen::VectorXd(there.force);
        },
        step);
    EXPECT_LE((derivative - here.tangent.col(i)).cwiseAbs().maxCoeff(),
              tolerance * here.tangent.cwiseAbs().maxCoeff())
        << "coordinate " << i;
  }
}

}  // namespace tremolo::testing
