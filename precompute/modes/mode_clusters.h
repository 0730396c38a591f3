// Modes of equal frequency, as every symmetric body has them, made the same on every run.
//
// Of such modes only their span is determined: a solver returns its columns turned by chance (the
// order of sums, the number of ranks). They are turned to the eigenvectors of V^T S M S V, in
// ascending order, where S is a symmetric operator that depends on the places of the vertices only
// and has no symmetry itself.
#pragma once

#include "precompute/modes/modes.h"

namespace tremolo {

// Neighbouring squared frequencies nearer than this, relative, are taken for equal. Rounding in K
// turns two solvers' vectors by up to 0.1 eps / (c * distance), c = Modes::cancellation (measured
// on beams of nearly square section, docs/theory.md): a compact body's that are told apart are the
// same to 1e-6 and better.
inline constexpr double kClusterGap = 1e-6;

// Which values are taken for equal: neighbours within `relative` of the larger one, or nearer than
// `absolute`, but never more than a thousandth apart.
struct Nearness {
  double relative = kClusterGap;
  double absolute = 0;
  bool operator()(double a, double b) const;
};

// Of squared frequencies of which the lowest is given, with its Modes::cancellation: a slender
// body's rounding is told from what differs.
Nearness nearness(double lowest, double cancellation);

// Columns first .. first + count - 1.
struct Cluster {
  Eigen::Index first = 0;
  Eigen::Index count = 0;
};

// Runs of two and more values, each near the one before. values: positive, sorted either way.
std::vector<Cluster> find_clusters(const Eigen::VectorXd& values, const Nearness& near);

// The run that the cut after `count` values goes through; a count of 0 when it goes through none.
Cluster cluster_at_cut(const Eigen::VectorXd& values, Eigen::Index count, const Nearness& near);

// S: a symmetric 3x3 block for each of this rank's nodes, in their order; dimensionless. Depends on
// the mesh by the places of its vertices relative to the box around them.
struct Marker {
  std::vector<Eigen::Matrix3d> blocks;
};
Marker make_marker(const TetMesh& mesh, const std::vector<int>& part_of_vertex,
                   const LocalDofs& local);

// The orthogonal matrix by which columns that are orthonormal in `mass` become canonical. vectors:
// local rows. Signs are left to fix_signs. On all ranks together.
Eigen::MatrixXd canonical_rotation(Mat mass, const Marker& marker, const Columns& vectors);

// Turns the columns of each cluster by it.
void make_canonical(Mat mass, const Marker& marker, const std::vector<Cluster>& clusters,
                    Columns& vectors);

// At most so many columns are added to a default so that it does not cut between equals.
inline constexpr Eigen::Index kMostAdded = 4;

// What the cut after `count` modes goes through, among values that are known: the modes' own and
// the first one left out. whole: the run of equals ends within them. available: eigenpairs there
// are.
struct ModeCut {
  Eigen::VectorXd values;
  Nearness near;
  Cluster cluster;
  bool whole = false;
};
ModeCut cut_of(const Modes& modes, int count, int available);

// Modes whose runs of equals are canonical. note: for the user, what was cut or added; empty:
// nothing.
struct WholeModes {
  Modes modes;
  std::string note;
};

// Turns runs of equals to their canonical vectors and cuts after `count` modes; with `extend` up to
// kMostAdded equals beyond the cut stay, else the first ones in the canonical order.
WholeModes make_whole(Mat mass, const Marker& marker, int count, int available, bool extend,
                      Modes modes);

}  // namespace tremolo
