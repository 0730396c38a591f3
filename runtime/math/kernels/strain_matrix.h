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
  };
  Workspace make_workspace() const;

  // out = M(q) v, r each. Returns v . M(q) v. Nothing is allocated.
  double multiply(const double* q, const double* v, Workspace& workspace, double* out) const;

  std::size_t size() const { return r_; }

 private:
  std::size_t r_;
  std::size_t padded_;  // pairs of (1, q), to whole vectors
  AlignedDoubles tiles_;
};

}  // namespace tremolo
