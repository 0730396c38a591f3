#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "runtime/apps/view/shape/collider_shape.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

// A cube is six tetrahedra around its diagonal from corner 0 to corner 7; corner bits are x, y, z.
// Neighbouring cubes divide their common face in the same way.
constexpr std::array<std::array<int, 4>, 6> kTetrahedra = {
    {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};

class Marcher {
 public:
  explicit Marcher(const DistanceGrid& grid) : grid_(grid) {
    const GridNodes& nodes = grid.nodes();
    const auto longest =
        static_cast<int>(*std::max_element(nodes.counts.begin(), nodes.counts.end()));
    stride_ = std::max(1, (longest - 1 + kMostIsoCells - 1) / kMostIsoCells);
    for (std::size_t axis = 0; axis < 3; ++axis)
      counts_[axis] = (static_cast<int>(nodes.counts[axis]) - 2) / stride_ + 2;
    sample();
  }

  TriangleShape take() {
    for (int k = 0; k + 1 < counts_[2]; ++k)
      for (int j = 0; j + 1 < counts_[1]; ++j)
        for (int i = 0; i + 1 < counts_[0]; ++i) cut_cube(i, j, k);
    return std::move(shape_);
  }

 private:
  std::size_t node(int i, int j, int k) const {
    return static_cast<std::size_t>((k * counts_[1] + j) * counts_[0] + i);
  }
  Vector3d place(std::size_t node) const {
    const std::size_t row = counts_[0];
    const auto layer = row * static_cast<std::size_t>(counts_[1]);
    const std::size_t step = stride_;
    return grid_.nodes().at(step * (node % row), step * (node % layer / row),
                            step * (node / layer));
  }
  void sample() {
    values_.resize(node(0, 0, counts_[2]));
    for (std::size_t n = 0; n < values_.size(); ++n) values_[n] = grid_.at(place(n)).distance;
  }

  void cut_cube(int i, int j, int k) {
    std::array<std::size_t, 8> corners{};
    int inside = 0;
    for (int c = 0; c < 8; ++c) {
      corners[c] = node(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1));
      inside += values_[corners[c]] < 0.0 ? 1 : 0;
    }
    if (inside == 0 || inside == 8) return;
    for (const std::array<int, 4>& tetrahedron : kTetrahedra) {
      std::array<std::size_t, 4> four{};
      for (std::size_t c = 0; c < 4; ++c) four[c] = corners[tetrahedron[c]];
      cut_tetrahedron(four);
    }
  }

  void cut_tetrahedron(const std::array<std::size_t, 4>& corners) {
    std::array<std::size_t, 4> in{}, out{};
    std::size_t ins = 0, outs = 0;
    for (const std::size_t corner : corners)
      (values_[corner] < 0.0 ? in[ins++] : out[outs++]) = corner;
    if (ins == 1)
      triangle(crossing(in[0], out[0]), crossing(in[0], out[1]), crossing(in[0], out[2]));
    if (ins == 3)
      triangle(crossing(in[0], out[0]), crossing(in[1], out[0]), crossing(in[2], out[0]));
    if (ins != 2) return;
    const std::uint32_t a = crossing(in[0], out[0]), b = crossing(in[0], out[1]);
    const std::uint32_t c = crossing(in[1], out[1]), d = crossing(in[1], out[0]);
    triangle(a, b, c);
    triangle(a, c, d);
  }

  // The vertex on the edge between two nodes, made once.
  std::uint32_t crossing(std::size_t inside, std::size_t outside) {
    const auto [low, high] = std::minmax(inside, outside);
    const auto [found, fresh] = vertices_.try_emplace(low * values_.size() + high, 0U);
    if (!fresh) return found->second;
    const double share = values_[inside] / (values_[inside] - values_[outside]);
    const Vector3d x = place(inside) + share * (place(outside) - place(inside));
    const Vector3d gradient = grid_.at(x).gradient;
    const double length = gradient.norm();
    return found->second =
               shape_.add(x, length > 0.0 ? Vector3d(gradient / length) : Vector3d::UnitZ());
  }

  // Adds a triangle, oriented by its normals.
  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const Eigen::Vector3f &x = shape_.positions[a], &y = shape_.positions[b];
    const Eigen::Vector3f& z = shape_.positions[c];
    const Eigen::Vector3f out = shape_.normals[a] + shape_.normals[b] + shape_.normals[c];
    if ((y - x).cross(z - x).dot(out) < 0.0f) std::swap(b, c);
    shape_.add_triangle(a, b, c);
  }

  const DistanceGrid& grid_;
  int stride_ = 1;
  std::array<int, 3> counts_{};  // sampled nodes along each axis
  std::vector<double> values_;
  std::unordered_map<std::size_t, std::uint32_t> vertices_;  // by both ends of their edge
  TriangleShape shape_;
};

}  // namespace

TriangleShape iso_surface(const DistanceGrid& grid) {
  return Marcher(grid).take();
}

}  // namespace tremolo
