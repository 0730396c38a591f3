// Canonical vectors for clusters of equal frequencies, which every symmetric body has.
//
// Only the span of a cluster is determined; an eigensolver returns an arbitrary orthonormal basis
// of it, which depends on the order of sums and on the number of ranks. The basis is rotated to the
// eigenvectors of V^T S M S V, in ascending order, where S is a symmetric operator that depends on
// the vertex positions only and has no symmetry itself.
#pragma once

#include "precompute/modes/modes.h"

namespace tremolo {

// Neighbouring squared frequencies closer than this, relative, count as equal. Rounding in K
// rotates the vectors of two solvers against each other by up to 0.1 eps / (c * distance), c =
// Modes::cancellation (measured on beams of nearly square section, docs/theory.md): in a compact
// body, modes that count as distinct agree to 1e-6 or better.
inline constexpr double kClusterGap = 1e-6;

// Decides which values count as equal: neighbours within `relative` of the larger one or within
// `absolute`, but never more than a thousandth apart.
struct Nearness {
  double relative = kClusterGap;
  double absolute = 0;
  bool operator()(double a, double b) const;
};

// Returns the tolerances for squared frequencies with the given lowest one and its
// Modes::cancellation, so that in a slender body rounding is distinguished from real differences.
Nearness nearness(double lowest, double cancellation);

// A run of columns, first .. first + count - 1.
struct Cluster {
  Eigen::Index first = 0;
  Eigen::Index count = 0;
};

// Returns the runs of two or more values, each near the previous one. values: positive, sorted
// either way.
std::vector<Cluster> find_clusters(const Eigen::VectorXd& values, const Nearness& near);

// Returns the cluster that the cut after `count` values divides; its count is 0 if there is none.
Cluster cluster_at_cut(const Eigen::VectorXd& values, Eigen::Index count, const Nearness& near);

// The operator S: a symmetric 3x3 block for each of this rank's nodes, in their order,
// dimensionless. It depends on the mesh through the vertex positions relative to the bounding box.
struct Marker {
  std::vector<Eigen::Matrix3d> blocks;
};
Marker make_marker(const TetMesh& mesh, const std::vector<int>& part_of_vertex,
                   const LocalDofs& local);

// Returns the orthogonal matrix that rotates M-orthonormal columns (local rows) to canonical ones.
// Signs are left to fix_signs. Collective.
Eigen::MatrixXd canonical_rotation(Mat mass, const Marker& marker, const Columns& vectors);

// Applies canonical_rotation to the columns of each cluster.
void make_canonical(Mat mass, const Marker& marker, const std::vector<Cluster>& clusters,
                    Columns& vectors);

// Most columns added to a default count so that the cut does not divide a cluster.
inline constexpr Eigen::Index kMostAdded = 4;

// The cluster divided by the cut after `count` modes. values: the known squared frequencies, i.e.
// those of the modes and the first one left out. whole: the cluster ends within them. available:
// number of eigenpairs of the pencil.
struct ModeCut {
  Eigen::VectorXd values;
  Nearness near;
  Cluster cluster;
  bool whole = false;
};
ModeCut cut_of(const Modes& modes, int count, int available);

// Modes whose clusters are canonical. note: for the user, on a divided or extended cluster; may be
// empty.
struct WholeModes {
  Modes modes;
  std::string note;
};

// Rotates clusters to their canonical vectors and keeps `count` modes. With `extend`, up to
// kMostAdded members of a divided cluster beyond the cut are kept too; else its first ones in
// canonical order.
WholeModes make_whole(Mat mass, const Marker& marker, int count, int available, bool extend,
                      Modes modes);

}  // namespace tremolo
