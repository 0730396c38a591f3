// VegaFEM's reduced models: the basis (.U) and the polynomials of its reduced internal forces
// (.cub). Both are little-endian.
//
//   .U     i32 rows, i32 columns, f64 entries column by column
//   .cub   i32 r, i32 L = r, i32 Q = r(r+1)/2, i32 C = r(r+1)(r+2)/6, then f64 matrices row by row:
//          linear r x L, quadratic r x Q, cubic r x C
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"

namespace tremolo {

// The internal force of coordinate i at q is
//     sum_j linear[i, j] q_j + sum_jk quadratic[i, jk] q_j q_k + sum_jkl cubic[i, jkl] q_j q_k q_l
// over j <= k <= l: a coefficient belongs to a monomial, all orderings of it summed. Each matrix is
// row-major, a row a force component, its monomials in lexicographic order: 00 01 .. 0r 11 12 ..
struct ReducedForces {
  std::size_t size = 0;           // r
  std::vector<double> linear;     // r x r
  std::vector<double> quadratic;  // r x r(r+1)/2
  std::vector<double> cubic;      // r x r(r+1)(r+2)/6
};

// The gradient of V = 1/2 q^T diag(lambda) q + C[q,q,q] + Q[q,q,q,q]; unique entries of C and Q as
// in common/packed_index.h, none at all for a linear model.
ReducedForces reduced_forces(const Eigen::VectorXd& lambda, std::span<const double> cubic,
                             std::span<const double> quartic);

// The forces at q, straightforwardly.
Eigen::VectorXd evaluate(const ReducedForces& forces, const Eigen::VectorXd& q);

// Reads the bytes of a file; `path` is for errors. Counts are compared with the file's size before
// memory is allocated; at most 4 096 coordinates. Errors (kContent) give the byte, the expected and
// the found value: also for values that are not finite and bytes after the last one.
Result<ReducedForces> read_cub(std::string_view bytes, const std::string& path);
Result<Eigen::MatrixXd> read_basis_matrix(std::string_view bytes, const std::string& path);

// Values -> bytes of a file. kContent when a count does not fit 32 bits; for .cub that is where
// VegaFEM's own product r x C ends, r = 336.
Result<std::string> cub_bytes(const ReducedForces& forces);
Result<std::string> basis_matrix_bytes(const Eigen::MatrixXd& basis);

}  // namespace tremolo
