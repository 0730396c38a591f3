// Triangles that are drawn as they are: colliders, the ground, hands.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace tremolo {

// positions, m, and unit normals: one per vertex. triangles: three indices each, counter-clockwise
// seen from outside.
struct TriangleShape {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector3f> normals;
  std::vector<std::uint32_t> triangles;

  std::uint32_t add(const Eigen::Vector3d& position, const Eigen::Vector3d& normal) {
    positions.push_back(position.cast<float>());
    normals.push_back(normal.cast<float>());
    return static_cast<std::uint32_t>(positions.size() - 1);
  }
  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    triangles.insert(triangles.end(), {a, b, c});
  }
};

}  // namespace tremolo
