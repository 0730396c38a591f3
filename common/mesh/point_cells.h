// Points in the cells of a grid, found by their positions.
#pragma once

#include <algorithm>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

namespace tremolo {

// Points in the cells of a grid, found by their position. Cells are as wide as the largest distance
// of a query, so that only the 27 around a point matter. Ids count the points in the order of their
// addition.
class PointCells {
 public:
  explicit PointCells(double width) : width_(width) {}

  // The id of a point closer to x than `distance`, which is at most the width; -1 if there is none.
  std::int32_t near(const Eigen::Vector3d& x, double distance) const {
    const Cell cell = cell_of(x);
    for (int i = 0; i < 27; ++i) {
      const auto found = ids_.find(key(cell + Cell(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)));
      if (found == ids_.end()) continue;
      for (const std::int32_t id : found->second)
        if ((points_[id] - x).squaredNorm() < distance * distance) return id;
    }
    return -1;
  }

  std::int32_t add(const Eigen::Vector3d& x) {
    const auto id = static_cast<std::int32_t>(points_.size());
    points_.push_back(x);
    ids_[key(cell_of(x))].push_back(id);
    return id;
  }

  // Adds x unless a point is nearer than `distance`, and says whether it did.
  bool add_if_apart(const Eigen::Vector3d& x, double distance) {
    if (near(x, distance) >= 0) return false;
    add(x);
    return true;
  }

  const std::vector<Eigen::Vector3d>& points() const { return points_; }

 private:
  using Cell = Eigen::Matrix<std::int64_t, 3, 1>;
  Cell cell_of(const Eigen::Vector3d& x) const {
    return (x / width_).array().floor().cast<std::int64_t>();
  }
  // Cells 2^21 apart share a key, which costs a comparison and no more.
  static std::uint64_t key(const Cell& cell) {
    std::uint64_t value = 0;
    for (const std::int64_t c : cell) value = (value << 21) | (c & 0x1fffffu);
    return value;
  }

  double width_;
  std::vector<Eigen::Vector3d> points_;
  std::unordered_map<std::uint64_t, std::vector<std::int32_t>> ids_;
};

}  // namespace tremolo
