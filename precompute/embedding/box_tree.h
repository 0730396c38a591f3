// A bounding volume tree for searches around a point. tremolo-precompute does not link CGAL, whose
// AABB tree the mesher uses.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "common/mesh/tet_mesh.h"

namespace tremolo {

// Zero inside the box, m^2.
inline double squared_distance(const BoundingBox& box, const Eigen::Vector3d& x) {
  return (box.low - x).cwiseMax(x - box.high).cwiseMax(0.0).squaredNorm();
}

class BoxTree {
 public:
  // An item's number is its index in `boxes`. Fewer than 2^31 of them.
  explicit BoxTree(const std::vector<BoundingBox>& boxes);

  struct Nearest {
    std::size_t item = 0;
    double squared_distance = std::numeric_limits<double>::infinity();
  };
  // distance(item) -> squared distance of x to the item, which is inside its box. Infinite if there
  // is none; the first one of several at the same distance.
  template <class Distance>
  Nearest nearest(const Eigen::Vector3d& x, const Distance& distance) const {
    Nearest best;
    walk(
        x, [&] { return best.squared_distance; },
        [&](std::size_t item) {
          const double found = distance(item);
          if (found < best.squared_distance) best = {item, found};
        });
    return best;
  }

  // Calls visit(item) for every item whose box is at most at that distance; always in the same
  // order.
  template <class Visit>
  void visit_near(const Eigen::Vector3d& x, double squared_radius, const Visit& visit) const {
    walk(
        x, [&] { return squared_radius; }, visit);
  }

 private:
  // A leaf has `count` items from `first` on; an inner node (count 0) has its first child behind it
  // and its second one at `first`.
  struct Node {
    BoundingBox box;
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };

  void build(const std::vector<BoundingBox>& boxes, std::uint32_t begin, std::uint32_t end);

  // Nearer nodes first; none that is further away than reach() then says.
  template <class Reach, class Visit>
  void walk(const Eigen::Vector3d& x, const Reach& reach, const Visit& visit) const {
    struct Stop {
      std::uint32_t node;
      double squared_distance;
    };
    std::array<Stop, 64> stack;  // the tree halves its items: it is at most 32 deep
    std::size_t depth = 0;
    if (!nodes_.empty()) stack[depth++] = {0, squared_distance(nodes_[0].box, x)};
    while (depth > 0) {
      const Stop at = stack[--depth];
      if (at.squared_distance > reach()) continue;
      const Node& node = nodes_[at.node];
      for (std::uint32_t i = 0; i < node.count; ++i) visit(std::size_t{items_[node.first + i]});
      if (node.count > 0) continue;
      Stop near{at.node + 1, squared_distance(nodes_[at.node + 1].box, x)};
      Stop far{node.first, squared_distance(nodes_[node.first].box, x)};
      if (far.squared_distance < near.squared_distance) std::swap(near, far);
      stack[depth++] = far;
      stack[depth++] = near;
    }
  }

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> items_;
};

}  // namespace tremolo
