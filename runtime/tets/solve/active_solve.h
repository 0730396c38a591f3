// A x = b over the active control points alone: conjugate gradients, preconditioned by the inverses
// of the diagonal's blocks (Hestenes and Stiefel 1952). The pattern is that of the fully quadratic
// mesh and stays; a list of what is active is made anew when edges change their degree, and blocks
// of other rows and columns are never touched.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "runtime/sparse/block_matrix.h"
#include "runtime/tets/solve/active_floats.h"

namespace tremolo {

// residual: |b - A x| over |b|, as the recurrence has it. positive: no direction with d.A d <= 0
// was met; where one was, x is what had been found before.
struct ActiveReport {
  int iterations = 0;
  double residual = 0.0;
  bool positive = true;
};

inline constexpr std::size_t kMostFolded = 10;
// Conjugate gradients that are asked for no less than this are in single precision.
inline constexpr double kSingleTolerance = 5e-4;

// A sum of shares times vectors of nodes, which are numbered among the active.
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
  // All memory is taken here: for all nodes active.
  ActiveSolve(BlockPatternPointer pattern, std::shared_ptr<const SmoothSpace> smooth);

  // active: a flag a node.
  void choose(std::span<const std::uint8_t> active);
  std::size_t active_nodes() const { return nodes_.size(); }

  // x <- A^-1 b from x = 0; entries of nodes that are not active become 0. Stops at a residual of
  // tolerance |b| or after most_iterations.
  ActiveReport solve(const BlockMatrix& a, const Eigen::VectorXd& b, double tolerance,
                     int most_iterations, Eigen::VectorXd& x);

  // The same in steps, for several systems that are coupled (tet_island.h). take_diagonal() and
  // add_diagonal() before start(); then multiply(), what couples is added to q, advance(), turn().
  FoldedPoint folded(std::span<const std::uint32_t> nodes, std::span<const double> shares) const;
  void take_diagonal(const BlockMatrix& a);
  // In single precision a matrix may instead be added up where it is multiplied: begin_single(),
  // then take_diagonal(); start() does not take `a` then.
  FloatTarget begin_single();
  void take_diagonal();
  // The smooth part of the matrix, without touches (smooth_matrix()); after take_diagonal(), which
  // leaves it out.
  void take_smooth(const Eigen::Matrix3d& turn, double mass, double stiffness);
  void add_diagonal(const FoldedPoint& point, const Eigen::Matrix3d& block);
  // x = 0, r = b, p = z = P r. single: what follows is in single precision.
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
    std::uint32_t column = 0;  // among the active
    std::uint32_t place = 0;
  };
  using Vectors = std::vector<Eigen::Vector3d>;
  SmoothMatrix smooth_inverse() const;

  static constexpr std::uint32_t kNoRank = ActiveFloats::kNoRank;

  BlockPatternPointer pattern_;
  std::shared_ptr<const SmoothSpace> smooth_space_;
  SmoothMatrix smooth_;
  bool has_smooth_ = false;
  std::vector<std::uint32_t> nodes_, rank_, first_;  // active nodes; their number by node
  std::vector<Entry> entries_;                       // below the diagonal, by rows
  std::vector<Eigen::Matrix3d> inverse_;
  Vectors x_, r_, z_, p_, q_;
  ActiveFloats floats_;
  bool single_ = false, added_ = false;  // added_: by begin_single()
};

}  // namespace tremolo
