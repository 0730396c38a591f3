// Divides items for a tree of boxes: halves by the longest side of the box around their middles.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Core>

namespace tremolo {

// Reorders `items`, at least one, so that the lower half comes first; returns the size of that
// half. middle(item): its position, m. Items with equal positions are in the order of their
// numbers, so that the tree depends on nothing else.
template <class Middle>
std::size_t split_at_median(std::span<std::uint32_t> items, const Middle& middle) {
  Eigen::Vector3d low = middle(items.front()), high = low;
  for (const std::uint32_t item : items) {
    const Eigen::Vector3d place = middle(item);
    low = low.cwiseMin(place);
    high = high.cwiseMax(place);
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  const auto half = items.begin() + static_cast<std::ptrdiff_t>(items.size() / 2);
  std::nth_element(items.begin(), half, items.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double x = middle(a)[axis], y = middle(b)[axis];
    return x < y || (x == y && a < b);
  });
  return items.size() / 2;
}

}  // namespace tremolo
