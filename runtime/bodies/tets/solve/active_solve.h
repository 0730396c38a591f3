// Solves A x = b over the active control points alone: conjugate gradients, preconditioned by the
// inverses of the diagonal's blocks (Hestenes and Stiefel 1952). The pattern is that of the fully
// quadratic mesh and constant. A list of the active nodes is made again when edges change their
// degree; blocks of other rows and columns are never read.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "runtime/bodies/tets/solve/active_floats.h"
#include "runtime/math/sparse/block_matrix.h"

namespace tremolo {

// Result of a solve.
struct ActiveReport {
  int iterations = 0;
  double residual = 0.0;  // |b - A x| over |b|, from the recurrence
  // No direction with d.A d <= 0 was met; otherwise x is the solution before it.
  bool positive = true;
};

inline constexpr std::size_t kMostFolded = 10;
// At this or a larger tolerance conjugate gradients use single precision.
inline constexpr double kSingleTolerance = 5e-4;

// A weighted sum of vectors of nodes, which are numbered among the active ones.
struct FoldedPoint {
  std::uint32_t count = 0;
  std::array<std::uint32_t, kMostFolded> nodes{};
  std::array<double, kMostFolded> shares{};
};

// r.r and r.z of a search.
struct SearchSizes {
  double square = 0.0, product = 0.0;
};

class ActiveSolve {
 public:
  // All memory is allocated here, for all nodes active.
  ActiveSolve(BlockPatternPointer pattern, std::shared_ptr<const SmoothSpace> smooth);

  // active: one flag per node.
  void choose(std::span<const std::uint8_t> active);
  std::size_t active_nodes() const { return nodes_.size(); }

  // x <- A^-1 b from x = 0; entries of nodes that are not active become 0. Stops at a residual of
  // tolerance |b| or after most_iterations.
  ActiveReport solve(const BlockMatrix& a, const Eigen::VectorXd& b, double tolerance,
                     int most_iterations, Eigen::VectorXd& x);

  // The same in steps, for several coupled systems (tet_island.h). Call take_diagonal() and
  // add_diagonal() before start(); then repeat multiply(), add the coupling terms to q, advance(),
  // turn().
  FoldedPoint folded(std::span<const std::uint32_t> nodes, std::span<const double> shares) const;
  void take_diagonal(const BlockMatrix& a);
  // In single precision a matrix may instead be summed where it is multiplied: begin_single(), then
  // take_diagonal(); start() does not use `a` then.
  FloatTarget begin_single();
  void take_diagonal();
  // Sets the smooth part of the matrix, without contacts (smooth_matrix()). Call it after
  // take_diagonal(), which removes it.
  void take_smooth(const Eigen::Matrix3d& turn, double mass, double stiffness);
  void add_diagonal(const FoldedPoint& point, const Eigen::Matrix3d& block);
  // x = 0, r = b, p = z = P r. single: the following calls use single precision.
  SearchSizes start(const BlockMatrix& a, const Eigen::VectorXd& b, bool single);
  double multiply(const BlockMatrix& a);  // q = A p; returns p.q
  // x += length p, r -= length q, z = P r.
  SearchSizes advance(double length);
  void turn(double share);  // p = z + share p
  void finish(Eigen::VectorXd& x) const;
  Eigen::Vector3d direction_at(const FoldedPoint& point) const;            // of p
  void add_image(const FoldedPoint& point, const Eigen::Vector3d& value);  // to q

  std::size_t bytes() const;

 private:
  struct Entry {
    std::uint32_t column = 0;  // index among the active nodes
    std::uint32_t place = 0;
  };
  using Vectors = std::vector<Eigen::Vector3d>;
  SmoothMatrix smooth_inverse() const;

  static constexpr std::uint32_t kNoRank = ActiveFloats::kNoRank;

  BlockPatternPointer pattern_;
  std::shared_ptr<const SmoothSpace> smooth_space_;
  SmoothMatrix smooth_;
  bool has_smooth_ = false;
  std::vector<std::uint32_t> nodes_, rank_, first_;  // active nodes; their index by node
  std::vector<Entry> entries_;                       // below the diagonal, by rows
  std::vector<Eigen::Matrix3d> inverse_;
  Vectors x_, r_, z_, p_, q_;
  ActiveFloats floats_;
  bool single_ = false, added_ = false;  // added_: by begin_single()
};

}  // namespace tremolo
