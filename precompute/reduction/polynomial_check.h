// Check of the reduced polynomial against the mesh's internal force: U^T f(Uq) against grad V(q).
#pragma once

#include "precompute/reduction/coefficients.h"

namespace tremolo {

// Returns |U^T f(Uq) - grad V(q)| / |grad V(q)| at a fixed pseudo-random q, scaled so that the
// largest vertex displacement is `reach`, m. solid, basis: of this rank's part of the mesh, whose
// first `counted` elements this rank sums. basis: 3n x r. Collective.
double polynomial_error(const Solid& solid, std::size_t counted, const BasisRows& basis,
                        const Eigen::VectorXd& lambda, const std::vector<double>& cubic,
                        const std::vector<double>& quartic, double reach);

}  // namespace tremolo
