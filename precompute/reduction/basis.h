// Stage "basis": reduces modes and derivatives to r coordinates (method of Barbic & James 2005,
// with a rotation that diagonalises the stiffness, so that coordinates are ordered by frequency).
#pragma once

#include <optional>

#include "precompute/modes/mode_clusters.h"
#include "precompute/reduction/many_columns.h"

namespace tremolo {

struct Basis {
  Columns vectors;                      // U: local dofs x r, kg^-1/2
  Eigen::VectorXd lambda;               // r, (rad/s)^2, ascending: U^T K U
  std::vector<double> singular_values;  // of the mass-PCA, descending, all
  double orthonormality_error = 0;      // max |U^T M U - I|
  double diagonality_error = 0;         // max |U^T K U - Lambda| / max Lambda
  Cluster cut;                          // cluster of equal singular values divided by the cut
};

// The weighted columns as M-orthonormal directions, columns * turn, ordered by their singular
// values, before the cut.
struct PrincipalColumns {
  Columns kept;          // local x s, M-orthonormal; exempt from the cut, they come first
  Columns columns;       // local x rank, orthogonalised against `kept`
  Eigen::MatrixXd q, t;  // columns * q is M-orthonormal, columns * q * t the input
  Eigen::MatrixXd turn;  // q times the left singular vectors of t
  Eigen::VectorXd singular_values;  // of t, descending, all
  Eigen::Index linear_modes = 0;    // k
  Eigen::Index rank = 0;            // number of singular values above rounding
  Eigen::Index size() const { return kept.cols() + rank; }

  // Returns the kept vectors and the first r - s directions, M-orthonormal; s <= r <= size().
  Columns first(Eigen::Index r) const;
};

// columns, w2, amplitude: see make_basis(). progress: receives messages if there are many
// columns (many_columns.h).
PrincipalColumns principal_columns(const Matrices& matrices, Columns columns,
                                   const Eigen::VectorXd& w2, double amplitude, unsigned threads,
                                   const Progress& progress = {});

// Adds vectors (local x s, independent) to those exempt from the cut; directions and singular
// values are recomputed from the columns orthogonalised against them.
void keep_always(const Matrices& matrices, Columns vectors, unsigned threads,
                 PrincipalColumns& principal);

// Returns the number of modes that keep_lowest_modes() keeps without a number asked for: half of r,
// and all of a cluster that this would divide, but fewer than r. w2: squared frequencies of the
// modes.
Eigen::Index lowest_modes(const Eigen::VectorXd& w2, int r);

// Adds the lowest modes to the vectors exempt from the cut after r directions: `asked` of them, or
// without a number as many as lowest_modes(), if the cut would put one of these more than a tenth,
// or one of the lowest r/4 more than 2 %, above its frequency. modes: local x k, with squared
// frequencies w2. Returns how many were added.
Eigen::Index keep_lowest_modes(const Matrices& matrices, const Columns& modes,
                               const Eigen::VectorXd& w2, int r, std::optional<int> asked,
                               unsigned threads, PrincipalColumns& principal);

// Options for truncating the directions.
struct BasisCut {
  int r = 0;
  unsigned threads = 1;
  // If set, coordinates of equal Lambda, and the selection among equal singular values at the cut,
  // are canonical (mode_clusters.h); else they depend on rounding.
  const Marker* marker = nullptr;
  bool extend = false;  // add up to kMostAdded coordinates if r would divide equal singular values
};

// Computes the basis. columns: local x (k + k(k+1)/2), the modes with squared frequencies w2 (k)
// and their derivatives (none for a linear scene); its memory is reused. amplitude: a, kg^1/2 m,
// the expected amplitude of the first mode. Columns are weighted Psi_i * w2_1/w2_i and Phi_ij *
// (a/2) w2_1^2/(w2_i w2_j), reduced to r by an SVD in the M inner product, and rotated by the
// eigenvectors of U^T K U. Without a, as in the literature, the weights of Psi and Phi have
// different units: the basis would depend on the body's size and mass, and a heavy body would lose
// its lowest modes to derivatives. Throws Failure (kContent) if r exceeds the rank of the columns.
Basis make_basis(const Matrices& matrices, Columns columns, const Eigen::VectorXd& w2,
                 double amplitude, const BasisCut& cut);

// Does the same for columns already weighted; r includes the kept ones.
Basis make_basis(const Matrices& matrices, PrincipalColumns principal, const BasisCut& cut);

// Returns a note for the user that names the modes whose frequency in the basis is more than 2 %
// too high; else "". w2: squared frequencies of the linear modes.
std::string note_on_modes(const Eigen::VectorXd& lambda, const Eigen::VectorXd& w2);

// Returns a note for the user if `asked` coordinates divide a cluster and `kept` were kept; else
// empty.
std::string note_on_cut(const Cluster& cut, Eigen::Index asked, Eigen::Index kept);

}  // namespace tremolo
