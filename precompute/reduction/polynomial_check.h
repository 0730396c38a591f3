// The check that the file's polynomial is the mesh's own force: U^T f(Uq) against grad V(q).
#pragma once

#include "precompute/reduction/coefficients.h"

namespace tremolo {

// |U^T f(Uq) - grad V(q)| / |grad V(q)| at a fixed pseudo-random q, scaled so that the largest
// vertex displacement is `reach` metres. solid, basis: of this rank's part of the mesh, of which
// the first `counted` elements are this rank's to sum; all ranks call it together. basis: 3n x r.
double polynomial_error(const Solid& solid, std::size_t counted, const BasisRows& basis,
                        const Eigen::VectorXd& lambda, const std::vector<double>& cubic,
                        const std::vector<double>& quartic, double reach);

}  // namespace tremolo
