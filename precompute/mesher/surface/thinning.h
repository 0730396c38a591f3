// Points that keep a distance from each other.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

namespace tremolo {

// Keeps points apart. Cells are as wide as the largest distance asked for, so only neighbours
// count.
class Thinning {
 public:
  explicit Thinning(double width) : width_(width) {}

  // Takes x if nothing taken is nearer than `apart`, which is at most the width.
  bool take(const Eigen::Vector3d& x, double apart) {
    const Eigen::Vector3i cell = (x / width_).array().floor().cast<int>();
    for (int i = -1; i <= 1; ++i)
      for (int j = -1; j <= 1; ++j)
        for (int k = -1; k <= 1; ++k) {
          const auto found = points_.find(key(cell + Eigen::Vector3i(i, j, k)));
          if (found == points_.end()) continue;
          for (const Eigen::Vector3d& other : found->second)
            if ((other - x).squaredNorm() < apart * apart) return false;
        }
    points_[key(cell)].push_back(x);
    return true;
  }

 private:
  static std::uint64_t key(const Eigen::Vector3i& cell) {
    std::uint64_t value = 0;
    for (const int c : cell) value = (value << 21) | (static_cast<std::uint64_t>(c) & 0x1fffffu);
    return value;
  }

  double width_;
  std::unordered_map<std::uint64_t, std::vector<Eigen::Vector3d>> points_;
};

}  // namespace tremolo
