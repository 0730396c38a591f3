// The nonlinear part of Kelvin-Voigt damping (docs/theory.md, "Stiffness damping"). The Green
// strains are the quadratic terms y(q) = (q_j, q_i q_j) times constants, so that with the Gram
// matrix G of these constants and J = dy/dq
//
//     V(q) = 1/2 y^T G y,      force of unit damping on the strain rates: J(q)^T G J(q) v.
//
// G's block of the linear terms is Lambda, whose damping the methods compute separately. This file
// has the rest,
//
//     M(q) v = J(q)^T G J(q) v - Lambda v.
//
// With z = (1, q) and dz = (0, v) the rates of all terms are w_ab = z_a dz_b + dz_a z_b, a <= b,
// and J^T y is (T + T^T) z for the packed triangle T of y. The only cost is a product with G, in
// which each coefficient is loaded once for its row and its column.
//
// In the blocks of the linear terms and the pairs, G = (Lambda B; B^T Q). With the rates v of the
// former and w of the latter the square of the strains' rate is that of two parts,
//
//     (v + Lambda^-1 B w)^T Lambda (v + Lambda^-1 B w) + w^T H w,      H = Q - B^T Lambda^-1 B.
//
// The stiff coordinates follow the soft ones so that nothing is stretched: they cancel in the first
// square, whatever cancels only in double. What is left, a small part of the stresses of Q, bears
// the rounding of float: multiply_quickly().
#pragma once

#include <cstddef>
#include <span>

#include "runtime/math/kernels/lanes.h"

namespace tremolo {

class StrainMatrix {
 public:
  // gram: packed as BasisData::strain_gram, of at least r coordinates; the leading r are used.
  StrainMatrix(std::size_t r, std::span<const double> gram);

  // Scratch of one caller.
  struct Workspace {
    AlignedDoubles z, dz;   // (1, q), (0, v); zeros behind
    AlignedDoubles rates;   // w
    AlignedDoubles stress;  // G w, without the linear block
    AlignedDoubles product;
    // Of multiply_quickly(); rates and stress have the pairs of q alone.
    AlignedDoubles q, v;
    AlignedDoubles linear;        // B w
    AlignedDoubles below;         // sums of H w in double
    AlignedFloats float_rates;    // w, scaled
    AlignedFloats float_stretch;  // v + Lambda^-1 B w, scaled
    AlignedFloats above;          // the other sums
    bool by_squares = false;      // multiply_quickly() had the last product
  };
  Workspace make_workspace() const;

  // out = M(q) v, r each. Returns v . M(q) v. Nothing is allocated.
  double multiply(const double* q, const double* v, Workspace& workspace, double* out) const;

  // The same in half the time: the stretch v + Lambda^-1 B w in double, the stresses B^T (its
  // Lambda-fold) + H w of the pairs in float. out is off by about 1e-7 of the force of these
  // stresses, and v . (M(q) + Lambda) v is never negative, apart from rounding in double.
  double multiply_quickly(const double* q, const double* v, Workspace& workspace,
                          double* out) const;

  // out = J(q)^T S - Lambda v with the stresses S = G J v of the last product, which may be that of
  // another q; r.
  void multiply_stress(const double* q, Workspace& workspace, double* out) const;

  std::size_t size() const { return r_; }

 private:
  void split(std::span<const double> gram);

  std::size_t r_;
  std::size_t padded_;  // pairs of (1, q), to whole vectors
  AlignedDoubles tiles_;
  AlignedDoubles stiffness_;      // Lambda
  AlignedDoubles coupling_;       // B: for each vector of rows all pairs, a vector each
  AlignedFloats float_coupling_;  // B/unit_: for each vector of pairs all rows
  AlignedFloats float_tiles_;     // H/unit_
  double unit_ = 1.0;             // the largest entry of H
};

}  // namespace tremolo
