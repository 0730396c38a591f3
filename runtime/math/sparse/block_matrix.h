// A symmetric matrix of 3 x 3 blocks, a row and a column of blocks for each node, with a fixed
// pattern and changing values: the matrix of a step of point masses.
//
// Only blocks (i, j) with j <= i are stored, row by row; A_ji = A_ij^T.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"

namespace tremolo {

using NodePair = std::pair<std::uint32_t, std::uint32_t>;

// The pattern of the stored blocks. first: size() + 1 entries; row i has the blocks first[i] to
// first[i + 1] - 1, their columns ascend, and the last one is the diagonal's.
class BlockPattern {
 public:
  // The diagonal, and the blocks of all pairs, in any order and with repeats. Errors (kContent): no
  // node, a node that is not below `nodes`, more than 2^31 blocks.
  static Result<std::shared_ptr<const BlockPattern>> create(std::size_t nodes,
                                                            std::span<const NodePair> pairs);

  std::size_t size() const { return first_.size() - 1; }
  std::size_t blocks() const { return column_.size(); }
  std::span<const std::uint32_t> first() const { return first_; }
  std::span<const std::uint32_t> columns() const { return column_; }
  std::size_t diagonal(std::size_t node) const { return first_[node + 1] - 1; }

  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  // The index of the block of rows a and columns b, or b and a; kNone if none is stored.
  std::size_t find(std::size_t a, std::size_t b) const;

 private:
  std::vector<std::uint32_t> first_, column_;
};

using BlockPatternPointer = std::shared_ptr<const BlockPattern>;

class BlockMatrix {
 public:
  explicit BlockMatrix(BlockPatternPointer pattern)
      : pattern_(std::move(pattern)), blocks_(pattern_->blocks(), Eigen::Matrix3d::Zero()) {}

  const BlockPattern& pattern() const { return *pattern_; }
  const BlockPatternPointer& shared_pattern() const { return pattern_; }

  // A block by its index from BlockPattern::find(): A_ij of its row i > j, or a symmetric one of
  // the diagonal.
  Eigen::Matrix3d& block(std::size_t place) { return blocks_[place]; }
  const Eigen::Matrix3d& block(std::size_t place) const { return blocks_[place]; }
  Eigen::Matrix3d& diagonal(std::size_t node) { return blocks_[pattern_->diagonal(node)]; }
  const Eigen::Matrix3d& diagonal(std::size_t node) const {
    return blocks_[pattern_->diagonal(node)];
  }

  void set_zero();

  // Replaces rows and columns of the nodes whose flag is not 0 by those of the identity. held: one
  // flag per node.
  void hold(std::span<const std::uint8_t> held);

  // y = A x. Both 3 size() long, not the same vector. Nothing is allocated.
  void multiply(const Eigen::VectorXd& x, Eigen::VectorXd& y) const { multiply({}, x, y); }
  // The same after hold() of these flags, without reading the rows of held nodes.
  void multiply(std::span<const std::uint8_t> held, const Eigen::VectorXd& x,
                Eigen::VectorXd& y) const;

 private:
  BlockPatternPointer pattern_;
  std::vector<Eigen::Matrix3d> blocks_;
};

}  // namespace tremolo
