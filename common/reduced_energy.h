// V(q) = 1/2 q^T diag(lambda) q + C[q,q,q] + Q[q,q,q,q] (docs/theory.md, "Reduced energy"), summed
// monomial by monomial from the unique entries. Slow, and independent of the runtime's kernels: a
// reference for tests.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace tremolo {

struct EnergyAndForce {
  double energy = 0.0;    // V, J
  Eigen::VectorXd force;  // grad V, r
};

// lambda: r, (rad/s)^2. cubic, quartic: unique entries (common/packed_index.h) of r coordinates,
// both empty for a linear model. q: r.
EnergyAndForce reduced_energy(const Eigen::VectorXd& lambda, const std::vector<double>& cubic,
                              const std::vector<double>& quartic, const Eigen::VectorXd& q);

}  // namespace tremolo
