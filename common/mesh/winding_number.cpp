#include "common/mesh/winding_number.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tremolo {
namespace {

constexpr std::size_t kLeaf = 8;
// A node is far when the distance to its centre is so many radii.
constexpr double kFar = 2.5;

Eigen::Vector3d area_vector(const Eigen::Matrix3d& t) {
  return 0.5 * (t.col(1) - t.col(0)).cross(t.col(2) - t.col(0));
}

// Solid angle of a triangle (van Oosterom and Strackee 1983).
double solid_angle(const Eigen::Matrix3d& t, const Eigen::Vector3d& x) {
  const Eigen::Vector3d a = t.col(0) - x, b = t.col(1) - x, c = t.col(2) - x;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double above = a.dot(b.cross(c));
  const double below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return above == 0.0 && below == 0.0 ? 0.0 : 2.0 * std::atan2(above, below);
}

}  // namespace

WindingNumber::WindingNumber(const SurfaceMesh& surface) {
  triangles_.reserve(surface.triangles.size());
  for (const Triangle& t : surface.triangles) {
    Corners corners;
    for (int i = 0; i < 3; ++i) corners.col(i) = surface.vertices[t[i]];
    triangles_.push_back(corners);
  }
  if (!triangles_.empty()) build(0, triangles_.size());
}

std::size_t WindingNumber::build(std::size_t first, std::size_t last) {
  const std::size_t self = nodes_.size();
  nodes_.emplace_back();
  Node node;
  node.first = first;
  node.last = last;
  double area = 0;
  Eigen::Vector3d low = triangles_[first].col(0), high = low;
  for (std::size_t i = first; i < last; ++i) {
    const Eigen::Vector3d vector = area_vector(triangles_[i]);
    const Eigen::Vector3d middle = triangles_[i].rowwise().mean();
    node.dipole += vector;
    node.centre += vector.norm() * middle;
    area += vector.norm();
    low = low.cwiseMin(middle);
    high = high.cwiseMax(middle);
  }
  node.centre =
      area > 0 ? Eigen::Vector3d(node.centre / area) : Eigen::Vector3d(0.5 * (low + high));
  for (std::size_t i = first; i < last; ++i) {
    const Eigen::Vector3d middle = triangles_[i].rowwise().mean();
    node.quadrupole += (middle - node.centre) * area_vector(triangles_[i]).transpose();
    for (int k = 0; k < 3; ++k)
      node.radius = std::max(node.radius, (triangles_[i].col(k) - node.centre).norm());
  }
  if (last - first > kLeaf) {
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const auto begin = triangles_.begin();
    const std::size_t middle = first + (last - first) / 2;
    std::nth_element(begin + first, begin + middle, begin + last,
                     [axis](const Corners& a, const Corners& b) {
                       return a.row(axis).sum() < b.row(axis).sum();
                     });
    build(first, middle);
    node.right = build(middle, last);
  }
  nodes_[self] = node;
  return self;
}

template <class Far, class Near>
void WindingNumber::visit(const Eigen::Vector3d& x, const Far& far, const Near& near) const {
  if (nodes_.empty()) return;
  std::size_t stack[64];
  std::size_t depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const std::size_t self = stack[--depth];
    const Node& node = nodes_[self];
    const Eigen::Vector3d d = node.centre - x;
    const double squared = d.squaredNorm();
    if (squared > kFar * kFar * node.radius * node.radius) {
      far(node, d, squared);
    } else if (node.right == 0) {
      for (std::size_t i = node.first; i < node.last; ++i) near(triangles_[i]);
    } else {
      stack[depth++] = node.right;
      stack[depth++] = self + 1;
    }
  }
}

double WindingNumber::at(const Eigen::Vector3d& x) const {
  double sum = 0;
  const auto far = [&sum](const Node& node, const Eigen::Vector3d& d, double squared) {
    // n . d / |d|^3 and its first derivative along (x - centre).
    const double cubed = squared * std::sqrt(squared);
    sum += d.dot(node.dipole) / cubed +
           (node.quadrupole.trace() - 3.0 * d.dot(node.quadrupole * d) / squared) / cubed;
  };
  visit(x, far, [&](const Corners& triangle) { sum += solid_angle(triangle, x); });
  return sum / (4.0 * std::numbers::pi);
}

std::size_t WindingNumber::cost_at(const Eigen::Vector3d& x) const {
  std::size_t cost = 1;
  visit(
      x, [&](const Node&, const Eigen::Vector3d&, double) { ++cost; },
      [&](const Corners&) { ++cost; });
  return cost;
}

}  // namespace tremolo
