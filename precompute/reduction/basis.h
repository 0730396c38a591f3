// Stage "basis": modes and derivatives -> r coordinates (method of Barbic & James 2005, with the
// rotation that makes the stiffness diagonal, so that "low" and "high" coordinates mean something).
#pragma once

#include "precompute/modes/mode_clusters.h"
#include "precompute/reduction/many_columns.h"

namespace tremolo {

struct Basis {
  Columns vectors;                      // U: local dofs x r, kg^-1/2
  Eigen::VectorXd lambda;               // r, (rad/s)^2, ascending: U^T K U
  std::vector<double> singular_values;  // of the mass-PCA, descending, all of them
  double orthonormality_error = 0;      // max |U^T M U - I|
  double diagonality_error = 0;         // max |U^T K U - Lambda| / max Lambda
  Cluster cut;                          // equal singular values on both sides of the cut
};

// The weighted columns as M-orthonormal directions in the order of their singular values, before
// the cut: columns * turn.
struct PrincipalColumns {
  Columns kept;                     // local x s, M-orthonormal: no cut takes them, they come first
  Columns columns;                  // local x rank, what is left of them beyond `kept`
  Eigen::MatrixXd q, t;             // columns * q is M-orthonormal, columns * q * t the input
  Eigen::MatrixXd turn;             // q times the left singular vectors of t
  Eigen::VectorXd singular_values;  // of t, descending, all
  Eigen::Index linear_modes = 0;    // k
  Eigen::Index rank = 0;            // singular values that are not rounding
  Eigen::Index size() const { return kept.cols() + rank; }

  // M-orthonormal: the kept ones and the first r - s directions, s <= r <= size().
  Columns first(Eigen::Index r) const;
};

// columns, w2, amplitude: as make_basis() has them.
// tell: hears what is under way of many columns (many_columns.h).
PrincipalColumns principal_columns(const Matrices& matrices, Columns columns,
                                   const Eigen::VectorXd& w2, double amplitude, unsigned threads,
                                   const Tell& tell = {});

// Takes vectors (local x s, independent) among those that no cut takes; the directions and their
// singular values are then of what the columns hold beyond them.
void keep_always(const Matrices& matrices, Columns vectors, unsigned threads,
                 PrincipalColumns& principal);

// What is kept of the directions. marker: coordinates of equal Lambda, and those to keep of several
// with equal singular values, are canonical (mode_clusters.h); without it they are what rounding
// makes them. extend: up to kMostAdded coordinates more than r, when r would cut between equal
// singular values.
struct BasisCut {
  int r = 0;
  unsigned threads = 1;
  const Marker* marker = nullptr;
  bool extend = false;
};

// columns: local x (k + k(k+1)/2), the modes with squared frequencies w2 (k) and their derivatives
// (none: a linear scene); taken, its memory is worked in. amplitude: a, kg^1/2 m, how far the first
// mode is expected to swing. Columns are weighted Psi_i * w2_1/w2_i and Phi_ij * (a/2) w2_1^2/(w2_i
// w2_j), reduced to r by an SVD in the M inner product, and rotated by the eigenvectors of U^T K U.
// Without a, as in the literature, the weights of Psi and Phi have different units: the basis would
// depend on the size and the mass of the body, and a heavy one would lose its lowest modes to
// derivatives. Throws Failure (kContent) if r exceeds the rank of the columns.
Basis make_basis(const Matrices& matrices, Columns columns, const Eigen::VectorXd& w2,
                 double amplitude, const BasisCut& cut);

// The same of columns already weighted; r counts the kept ones.
Basis make_basis(const Matrices& matrices, PrincipalColumns principal, const BasisCut& cut);

// What the user should know when `asked` coordinates cut between equals and `kept` were kept; empty
// when they did not.
std::string note_on_cut(const Cluster& cut, Eigen::Index asked, Eigen::Index kept);

}  // namespace tremolo
