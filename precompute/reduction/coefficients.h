// Stage "coefficients": the exact quartic energy in the basis (docs/theory.md, section "Reduced
// energy"; thesis (4.1.9)).
//
// With displacement gradients G_i of the basis columns, the Green strain of u = Uq is exactly
//   E = sum_i q_i sym(G_i) + sum_{i<=j} q_i q_j * { 1/2 G_i^T G_i or sym(G_i^T G_j) }.
// With y = [q_i ; q_i q_j (i<=j)] the energy is 1/2 y^T (sum_e B_e^T B_e) y, where the six rows of
// B_e are sqrt(weight) * sqrt(elasticity) * strain coefficients in Mandel's notation.
#pragma once

#include <vector>

#include "formats/basis/basis_data.h"
#include "precompute/fem/stvk.h"

namespace tremolo {

// Returns sum_e B_e^T B_e over elements first .. last-1: square, r + r(r+1)/2, lower triangle
// valid. basis: 3n x r. Each batch of elements is one BLAS SYRK; the work is divided among threads
// in a fixed way, so the sum does not depend on their number.
Eigen::MatrixXd strain_gram(const Solid& solid, const BasisRows& basis, std::size_t first,
                            std::size_t last, unsigned threads);

// Unique entries of the symmetric tensors of V = 1/2 q^T diag(lambda) q + C[q,q,q] + Q[q,q,q,q], in
// packed_index order.
struct Coefficients {
  Eigen::MatrixXd quadratic;    // r x r: the Hessian at rest, diag(lambda) up to rounding
  std::vector<double> cubic;    // J
  std::vector<double> quartic;  // J
};
Coefficients coefficients_from_gram(const Eigen::MatrixXd& gram, int r);

// The lower triangle of strain_gram() as BasisData::strain_gram stores it.
std::vector<double> packed_strain_gram(const Eigen::MatrixXd& gram, int r);

}  // namespace tremolo
