#include "precompute/embedding/box_tree.h"

#include <numeric>

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
  BoundingBox middles{middle(items_[begin]), middle(items_[begin])};
  for (std::uint32_t i = begin; i < end; ++i) {
    box.low = box.low.cwiseMin(boxes[items_[i]].low);
    box.high = box.high.cwiseMax(boxes[items_[i]].high);
    middles.low = middles.low.cwiseMin(middle(items_[i]));
    middles.high = middles.high.cwiseMax(middle(items_[i]));
  }
  nodes_.push_back({box, begin, end - begin});
  if (end - begin <= kLeaf) return;
  int axis = 0;
  (middles.high - middles.low).maxCoeff(&axis);
  const std::uint32_t half = begin + (end - begin) / 2;
  std::nth_element(items_.begin() + begin, items_.begin() + half, items_.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const double x = middle(a)[axis], y = middle(b)[axis];
                     return x != y ? x < y : a < b;
                   });
  build(boxes, begin, half);
  const auto second = static_cast<std::uint32_t>(nodes_.size());
  build(boxes, half, end);
  nodes_[at].first = second;
  nodes_[at].count = 0;
}

}  // namespace tremolo
