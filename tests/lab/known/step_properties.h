// Properties of one step of a method: symplecticity, reversibility, energy conservation, order.
//
// State and momentum are scaled to comparable size by a canonical change of variables, (sigma q,
// p/sigma) with sigma^2 the middle frequency, so that the numbers are relative ones.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "runtime/integrator.h"

namespace tremolo::known {

// The properties that theory gives without load and damping; for Newmark with default parameters.
struct Promise {
  int order = 0;
  bool symplectic = false;
  bool reversible = false;
  bool energy = false;  // H is kept exactly
};

// Empty for a name that is not in the list.
std::optional<Promise> promise_of(std::string_view method);

// The derivative of a step map at `state`, in the scaled variables, 2r x 2r: central differences of
// eighth order. The integrators compute in doubles, so the complex step is not available; the
// closed-form Jacobian of Verlet shows the accuracy. Empty if a solve fails.
std::optional<Eigen::MatrixXd> step_jacobian(Integrator& integrator, const State& state,
                                             double sigma);

// The derivative of a Verlet step of length h, from K(q0) and K(q1): kick, drift, kick.
Eigen::MatrixXd verlet_jacobian(const Model& model, const State& state, double h, double sigma);

// max |J^T Omega J - Omega|.
double symplectic_defect(const Eigen::MatrixXd& jacobian);

// |Phi(-p of Phi(z)) with p negated - z| over |z|, scaled. Empty if a solve fails.
std::optional<double> reversal_error(Integrator& integrator, const State& state, double sigma);

struct StepProperties {
  std::string method;
  std::optional<double> defect;
  std::optional<double> reversal;
  std::optional<double> energy;      // |H1 - H0| / H0 of one step
  std::vector<double> order_errors;  // scaled, relative, at h, h/2, h/4, h/8
  std::optional<double> order;       // least-squares slope of their logarithms
};

// Defect, reversal and energy at a step of `step`, the order from `order_step` over 32 such steps,
// on the spring chain at its strongly nonlinear state. The splitting methods hold the first two
// coordinates explicit. Throws a Failure as make_integrator.
StepProperties measure_step(std::string_view method, double step, double order_step);

// The largest entry of |step_jacobian - verlet_jacobian| for `verlet` on the spring chain; scale:
// of the state, near 0 the model is linear.
double jacobian_accuracy(double step, double scale);

}  // namespace tremolo::known
