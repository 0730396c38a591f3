// Stage "basis": modes and derivatives -> r coordinates (method of Barbic & James 2005, with the
// rotation that makes the stiffness diagonal, so that "low" and "high" coordinates mean something).
#pragma once

#include "precompute/matrices.h"

namespace tremolo {

struct Basis {
  Columns vectors;                      // U: local dofs x r, kg^-1/2
  Eigen::VectorXd lambda;               // r, (rad/s)^2, ascending: U^T K U
  std::vector<double> singular_values;  // of the mass-PCA, descending, all of them
  double orthonormality_error = 0;      // max |U^T M U - I|
  double diagonality_error = 0;         // max |U^T K U - Lambda| / max Lambda
};

// columns: local x (k + k(k+1)/2), the modes with squared frequencies w2 (k) and their derivatives
// (none: a linear scene); taken, its memory is worked in. amplitude: a, kg^1/2 m, how far the first
// mode is expected to swing. Columns are weighted Psi_i * w2_1/w2_i and Phi_ij * (a/2) w2_1^2/(w2_i
// w2_j), reduced to r by an SVD in the M inner product, and rotated by the eigenvectors of U^T K U.
// Without a, as in the literature, the weights of Psi and Phi have different units: the basis would
// depend on the size and the mass of the body, and a heavy one would lose its lowest modes to
// derivatives. Throws Failure (kContent) if r exceeds the rank of the columns.
Basis make_basis(const Matrices& matrices, Columns columns, const Eigen::VectorXd& w2,
                 double amplitude, int r, unsigned threads);

}  // namespace tremolo
