#include "precompute/embedding/box_tree.h"

#include <numeric>

#include "common/mesh/median_split.h"

namespace tremolo {

BoxTree::BoxTree(const std::vector<BoundingBox>& boxes) : items_(boxes.size()) {
  std::iota(items_.begin(), items_.end(), 0u);
  nodes_.reserve(boxes.size());
  if (!boxes.empty()) build(boxes, 0, static_cast<std::uint32_t>(boxes.size()));
}

void BoxTree::build(const std::vector<BoundingBox>& boxes, std::uint32_t begin, std::uint32_t end) {
  constexpr std::uint32_t kLeaf = 4;
  const std::size_t at = nodes_.size();
  BoundingBox box = boxes[items_[begin]];
  const auto middle = [&boxes](std::uint32_t item) {
    return Eigen::Vector3d(0.5 * (boxes[item].low + boxes[item].high));
  };
  for (std::uint32_t i = begin; i < end; ++i) {
    box.low = box.low.cwiseMin(boxes[items_[i]].low);
    box.high = box.high.cwiseMax(boxes[items_[i]].high);
  }
  nodes_.push_back({box, begin, end - begin});
  if (end - begin <= kLeaf) return;
  const std::uint32_t half = begin + static_cast<std::uint32_t>(split_at_median(
                                         std::span(items_).subspan(begin, end - begin), middle));
  build(boxes, begin, half);
  const auto second = static_cast<std::uint32_t>(nodes_.size());
  build(boxes, half, end);
  nodes_[at].first = second;
  nodes_[at].count = 0;
}

}  // namespace tremolo
