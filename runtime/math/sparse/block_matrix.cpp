#include "runtime/math/sparse/block_matrix.h"

#include <algorithm>
#include <limits>
#include <string>

namespace tremolo {

Result<BlockPatternPointer> BlockPattern::create(std::size_t nodes,
                                                 std::span<const NodePair> pairs) {
  constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max();
  if (nodes == 0) return content_error("a matrix of no nodes");
  if (nodes > kMost || pairs.size() > kMost - nodes)
    return content_error("a matrix of more than 2^31 blocks");
  std::vector<NodePair> sorted;
  sorted.reserve(pairs.size() + nodes);
  for (const auto& [a, b] : pairs) {
    if (std::max(a, b) >= nodes)
      return content_error("node " + std::to_string(std::max(a, b)) + " of a pair is not one of " +
                           std::to_string(nodes));
    sorted.emplace_back(std::max(a, b), std::min(a, b));
  }
  for (std::size_t i = 0; i < nodes; ++i) {
    const auto node = static_cast<std::uint32_t>(i);
    sorted.emplace_back(node, node);
  }
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  auto pattern = std::make_shared<BlockPattern>();
  pattern->first_.assign(nodes + 1, 0);
  pattern->column_.reserve(sorted.size());
  for (const auto& [row, column] : sorted) {
    ++pattern->first_[row + 1];
    pattern->column_.push_back(column);
  }
  for (std::size_t i = 0; i < nodes; ++i) pattern->first_[i + 1] += pattern->first_[i];
  return BlockPatternPointer(std::move(pattern));
}

std::size_t BlockPattern::find(std::size_t a, std::size_t b) const {
  if (a < b) std::swap(a, b);
  if (a >= size()) return kNone;
  const auto begin = column_.begin() + static_cast<std::ptrdiff_t>(first_[a]);
  const auto end = column_.begin() + static_cast<std::ptrdiff_t>(first_[a + 1]);
  const auto found = std::lower_bound(begin, end, b);
  if (found == end || *found != b) return kNone;
  return static_cast<std::size_t>(found - column_.begin());
}

void BlockMatrix::set_zero() {
  std::fill(blocks_.begin(), blocks_.end(), Eigen::Matrix3d::Zero());
}

void BlockMatrix::hold(std::span<const std::uint8_t> held) {
  const auto first = pattern_->first();
  const auto columns = pattern_->columns();
  for (std::size_t i = 0; i < pattern_->size(); ++i)
    for (std::size_t p = first[i]; p < first[i + 1]; ++p) {
      if (held[i] == 0 && held[columns[p]] == 0) continue;
      if (columns[p] == i)
        blocks_[p].setIdentity();
      else
        blocks_[p].setZero();
    }
}

void BlockMatrix::multiply(std::span<const std::uint8_t> held, const Eigen::VectorXd& x,
                           Eigen::VectorXd& y) const {
  const auto first = pattern_->first();
  const auto columns = pattern_->columns();
  for (std::size_t i = 0; i < pattern_->size(); ++i) {
    const Eigen::Vector3d own = x.segment<3>(3 * i);
    if (!held.empty() && held[i] != 0) {
      y.segment<3>(3 * i) = own;
      continue;
    }
    Eigen::Vector3d sum = blocks_[first[i + 1] - 1] * own;
    for (std::size_t p = first[i]; p + 1 < first[i + 1]; ++p) {
      const Eigen::Index j = 3 * static_cast<std::size_t>(columns[p]);
      sum += blocks_[p] * x.segment<3>(j);
      y.segment<3>(j) += blocks_[p].transpose() * own;
    }
    y.segment<3>(3 * i) = sum;
  }
}

}  // namespace tremolo
