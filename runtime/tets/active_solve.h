// A x = b over the active control points alone: conjugate gradients, preconditioned by the inverses
// of the diagonal's blocks (Hestenes and Stiefel 1952). The pattern is that of the fully quadratic
// mesh and stays; a list of what is active is made anew when edges change their degree, and blocks
// of other rows and columns are never touched.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/sparse/block_matrix.h"

namespace tremolo {

// residual: |b - A x| over |b|, as the recurrence has it. positive: no direction with d.A d <= 0
// was met; where one was, x is what had been found before.
struct ActiveReport {
  int iterations = 0;
  double residual = 0.0;
  bool positive = true;
};

class ActiveSolve {
 public:
  // All memory is taken here: for all nodes active.
  explicit ActiveSolve(BlockPatternPointer pattern);

  // active: a flag a node.
  void choose(std::span<const std::uint8_t> active);
  std::size_t active_nodes() const { return nodes_.size(); }

  // x <- A^-1 b from x = 0; entries of nodes that are not active become 0. Stops at a residual of
  // tolerance |b| or after most_iterations.
  ActiveReport solve(const BlockMatrix& a, const Eigen::VectorXd& b, double tolerance,
                     int most_iterations, Eigen::VectorXd& x);

  std::size_t bytes() const;

 private:
  struct Entry {
    std::uint32_t column = 0;  // among the active
    std::uint32_t place = 0;
  };
  using Vectors = std::vector<Eigen::Vector3d>;

  void invert_diagonal(const BlockMatrix& a);
  double multiply(const BlockMatrix& a);  // q = A p; returns p.q
  double precondition();                  // z = D^-1 r; returns r.z

  BlockPatternPointer pattern_;
  std::vector<std::uint32_t> nodes_, rank_, first_;  // active nodes; their number by node
  std::vector<Entry> entries_;                       // below the diagonal, by rows
  std::vector<Eigen::Matrix3d> inverse_;
  Vectors x_, r_, z_, p_, q_;
};

}  // namespace tremolo
