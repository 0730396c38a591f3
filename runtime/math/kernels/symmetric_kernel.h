// The quartic and cubic part of the reduced energy from unique coefficients, each loaded once and
// used in all its roles.
//
// With monomial coefficients c_ijkl = orderings(i,j,k,l) Q_ijkl and d_ijk = orderings(i,j,k) C_ijk,
// and a constant coordinate q_r = 1 that takes the place of l in the cubic terms, both parts are
//
//     P(q) = sum over i <= j <= k <= l <= r, k < r, of c_ijkl q_i q_j q_k q_l.
//
// Row (k, l) holds c_ijkl for all pairs i <= j <= k in the order of pair_index, padded with zeros
// to whole vectors. From it
//
//     W_kl = sum_ij c_ijkl q_i q_j,   E_ij = sum_kl c_ijkl q_k q_l,
//     Z^k_ij = sum over l of c_ijkl q_l (l >= k) and of c_ijlk q_l (l <= k; twice for l = k),
//
// and with F = E + W (pairs i <= j), y^k = (Z^k + Z^k^T) q (rows 0..k):
//
//     P = E . x,   grad P = (F + F^T) q + W_.r,   Hess P = B + B^T,   B_jk = F_jk + y^k_j,
//
// where x_ij = q_i q_j; E costs nothing, by 2E = sum_k q_k Z^k + Z^r. The gradient needs two
// multiply-adds a coefficient, the Hessian with gradient and value three.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "runtime/math/kernels/lanes.h"

namespace tremolo {

class SymmetricKernel {
 public:
  SymmetricKernel() = default;
  // cubic, quartic: unique tensor entries as in common/packed_index.h; the leading r are used.
  SymmetricKernel(std::size_t r, std::span<const double> cubic, std::span<const double> quartic);

  std::size_t size() const { return r_; }
  std::size_t bytes() const { return rows_.size() * sizeof(double); }  // read by one evaluation

  // Scratch of one caller, arrays named as in the equations. Pairs are in the order of pair_index.
  struct Workspace {
    AlignedDoubles q;    // q_0 .. q_(r-1), then 1, then zeros
    AlignedDoubles x;    // pairs
    AlignedDoubles e;    // E, then F: pairs
    AlignedDoubles w;    // W_kl, k <= l < r: pairs
    AlignedDoubles w_r;  // W_.r: r
    AlignedDoubles z;    // Z^0 .. Z^r, pairs each, z_stride_ apart
    AlignedDoubles y;    // y^k: r
  };
  Workspace make_workspace() const;

  // P(q), with one multiply-add a coefficient. q: r.
  double value(const double* q, Workspace& workspace) const;
  // P(q) and grad P. q: r. gradient: r, overwritten.
  double gradient(const double* q, Workspace& workspace, double* gradient) const;
  // grad P at two points with one pass over the coefficients.
  void gradient_pair(const double* q0, const double* q1, Workspace& workspace0,
                     Workspace& workspace1, double* gradient0, double* gradient1) const;
  // P(q), grad P and Hess P (r x r, both triangles).
  double hessian(const double* q, Workspace& workspace, double* gradient, double* hessian) const;

 private:
  std::size_t r_ = 0;
  std::size_t z_stride_ = 0;  // doubles from Z^k to Z^(k+1)
  AlignedDoubles rows_;       // (k, l) for k in [0, r), l in [k, r], each padded_pairs(k) long
};

}  // namespace tremolo
