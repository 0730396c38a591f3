// The potential as a matrix over index pairs, for evaluations at more than one point. With the
// pairs a = (i <= j) in the order of pair_index,
//
//     A = S X,   S_ab = Q_ijkl,      B_a = sum_k C_ijk q_k
//
// for any symmetric X in pair form (X_a = x_ij + x_ji for i < j, x_ii on the diagonal) and any q.
// S is symmetric: a coefficient that is loaded once serves its row and its column, two
// multiply-adds. That is C(p+1,2) coefficients for p = C(r+1,2) pairs, 2.4 times the unique ones
// at r = 20, but one product gives everything without a second stage: see potential.h.
#pragma once

#include <cstddef>
#include <span>

#include "runtime/math/kernels/lanes.h"

namespace tremolo {

class PairKernel {
 public:
  PairKernel() = default;
  // cubic, quartic: unique tensor entries as in common/packed_index.h; the leading r are used.
  PairKernel(std::size_t r, std::span<const double> cubic, std::span<const double> quartic);

  std::size_t padded_pairs() const { return padded_; }  // length of x, A and B below
  std::size_t bytes() const { return (s_.size() + c_.size()) * sizeof(double); }

  // X_a of q q^T; with `more`, of q q^T + s^2 more more^T. pairs: padded_pairs().
  void fill_pairs(const double* q, double* pairs) const;
  void fill_pairs(const double* q, const double* more, double s2, double* pairs) const;

  // A_a += sum over b >= first of S_ab X_b, for the pairs a >= first. X must be zero below first.
  void multiply(const double* x, std::size_t first, double* a) const;
  // A_a = sum over b < first of S_ab X_b, for the pairs a >= first. X must be zero from first on.
  void multiply_leading(const double* x, std::size_t first, double* a) const;
  // B_a += sum over k in [k_first, k_end) of C_ijk q_k, for the pairs a >= first.
  void contract_cubic(const double* q, std::size_t k_first, std::size_t k_end, std::size_t first,
                      double* b) const;
  // B of q and B of s in one pass, all pairs; overwritten.
  void contract_cubic_twice(const double* q, const double* s, double* bq, double* bs) const;

 private:
  std::size_t r_ = 0;
  std::size_t padded_ = 0;  // pairs, to whole vectors
  // S: groups of eight columns b, in each the vectors of the rows a <= b, interleaved; halves on
  // the diagonal, zeros below it.
  AlignedDoubles s_;
  AlignedDoubles c_;  // C_ijk: for each vector of pairs, all k
};

}  // namespace tremolo
