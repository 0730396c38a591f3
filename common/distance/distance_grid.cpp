#include "common/distance/distance_grid.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/hash.h"

namespace tremolo {
namespace {

std::string node_text(std::size_t i, std::size_t j, std::size_t k) {
  return "node (" + std::to_string(i) + ", " + std::to_string(j) + ", " + std::to_string(k) + ")";
}

// Distances along an axis change by the spacing at most; values were rounded to float.
bool may_be_neighbours(float a, float b, double spacing) {
  const double rounding = 1e-6 * (std::abs(double{a}) + std::abs(double{b}));
  return std::abs(double{a} - double{b}) <= 1.001 * spacing + rounding;
}

Status check_values(const GridNodes& nodes, std::span<const float> values) {
  const auto [nx, ny, nz] = nodes.counts;
  const std::size_t row = nx, layer = row * ny;
  const double longest = 1.001 * (nodes.at(nx - 1, ny - 1, nz - 1) - nodes.origin).norm();
  std::size_t at = 0;
  for (std::size_t k = 0; k < nz; ++k)
    for (std::size_t j = 0; j < ny; ++j)
      for (std::size_t i = 0; i < nx; ++i, ++at) {
        const float value = values[at];
        if (!(std::abs(double{value}) <= longest))
          return content_error("the distance at " + node_text(i, j, k) +
                               " is not finite or larger than the grid");
        const bool border = i == 0 || j == 0 || k == 0 || i + 1 == nx || j + 1 == ny || k + 1 == nz;
        if (border && !(value > 0.0F))
          return content_error("the distance at " + node_text(i, j, k) +
                               " on the border is not positive: the surface needs a margin");
        if ((i > 0 && !may_be_neighbours(value, values[at - 1], nodes.spacing)) ||
            (j > 0 && !may_be_neighbours(value, values[at - row], nodes.spacing)) ||
            (k > 0 && !may_be_neighbours(value, values[at - layer], nodes.spacing)))
          return content_error("the distance at " + node_text(i, j, k) +
                               " differs from a neighbour's by more than they are apart");
      }
  return Success{};
}

// The values at `count` nodes, `stride` apart, become coefficients of the quadratic spline that
// takes them: (c[i-1] + 6 c[i] + c[i+1]) / 8 = f[i]. At both ends the outermost half cell continues
// the polynomial of the next cell, which makes c[0] = c[1] + f[0] - f[1]. pivots, line: work space.
void filter_line(float* values, std::size_t count, std::size_t stride,
                 std::span<const double> pivots, std::vector<double>& line) {
  for (std::size_t i = 0; i < count; ++i) line[i] = values[i * stride];
  const double first = line[0] - line[1], last = line[count - 1] - line[count - 2];
  for (std::size_t i = 1; i + 1 < count; ++i) line[i] *= 8.0;
  line[1] -= first;
  line[count - 2] -= last;
  for (std::size_t i = 2; i + 1 < count; ++i) line[i] -= line[i - 1] / pivots[i - 1];
  line[count - 2] /= pivots[count - 2];
  for (std::size_t i = count - 3; i > 0; --i) line[i] = (line[i] - line[i + 1]) / pivots[i];
  line[0] = line[1] + first;
  line[count - 1] = line[count - 2] + last;
  for (std::size_t i = 0; i < count; ++i) values[i * stride] = static_cast<float>(line[i]);
}

// Pivots of the elimination of that tridiagonal matrix, whose first and last diagonal entries
// are 7.
std::vector<double> filter_pivots(std::size_t count) {
  std::vector<double> pivots(count, 1.0);
  for (std::size_t i = 1; i + 1 < count; ++i) {
    const bool end = i == 1 || i + 2 == count;
    pivots[i] = (end ? 7.0 : 6.0) - (i == 1 ? 0.0 : 1.0 / pivots[i - 1]);
  }
  return pivots;
}

// The three coefficients that affect a point along one axis, and their weights.
struct Stencil {
  std::size_t first;
  double value[3];
  double slope[3];  // per cell
};

// u: the position in cells, within 0 .. count - 1.
Stencil stencil_at(double u, std::size_t count) {
  const auto nearest = static_cast<std::size_t>(u + 0.5);
  const std::size_t middle = std::clamp<std::size_t>(nearest, 1, count - 2);
  const double t = u - static_cast<double>(middle);
  return {middle - 1,
          {0.5 * (0.5 - t) * (0.5 - t), 0.75 - t * t, 0.5 * (0.5 + t) * (0.5 + t)},
          {t - 0.5, -2.0 * t, t + 0.5}};
}

}  // namespace

Status check(const GridNodes& nodes) {
  std::size_t size = 1;
  for (const std::uint32_t count : nodes.counts) {
    if (count < kLeastGridNodes || count > kMostGridNodes)
      return content_error(std::to_string(count) + " nodes along an axis: expected " +
                           std::to_string(kLeastGridNodes) + " to " +
                           std::to_string(kMostGridNodes));
    size *= count;
  }
  if (size > kMostNodesOfGrid)
    return content_error(std::to_string(size) + " nodes: expected " +
                         std::to_string(kMostNodesOfGrid) + " at most");
  const double reach = nodes.origin.cwiseAbs().maxCoeff() + kMostGridNodes * nodes.spacing;
  if (!nodes.origin.allFinite() || !std::isfinite(reach) || !(nodes.spacing > 1e-9 * reach) ||
      !(nodes.spacing > 1e-30 && nodes.spacing < 1e30))
    return content_error("the grid's origin or spacing is not finite or out of range");
  return Success{};
}

Result<DistanceGrid> DistanceGrid::create(const GridNodes& nodes, std::span<const float> values) {
  if (Status status = check(nodes); !status) return status.error();
  if (values.size() != nodes.size())
    return content_error("there are " + std::to_string(values.size()) + " distances for " +
                         std::to_string(nodes.size()) + " nodes");
  if (Status status = check_values(nodes, values); !status) return status.error();
  DistanceGrid grid(nodes);
  grid.find_boxes(values);
  grid.coefficients_.assign(values.begin(), values.end());
  grid.filter();
  return grid;
}

// All corners of a cell that intersects the solid are within its diagonal of it.
void DistanceGrid::find_boxes(std::span<const float> values) {
  const auto [nx, ny, nz] = nodes_.counts;
  box_ = {nodes_.origin, nodes_.at(nx - 1, ny - 1, nz - 1)};
  solid_box_ = {box_.high, box_.low};
  const double near = std::sqrt(3.0) * nodes_.spacing;
  std::size_t at = 0;
  for (std::size_t k = 0; k < nz; ++k)
    for (std::size_t j = 0; j < ny; ++j)
      for (std::size_t i = 0; i < nx; ++i, ++at) {
        if (values[at] > near) continue;
        solid_box_.low = solid_box_.low.cwiseMin(nodes_.at(i, j, k));
        solid_box_.high = solid_box_.high.cwiseMax(nodes_.at(i, j, k));
      }
  if ((solid_box_.low.array() > solid_box_.high.array()).any()) solid_box_ = box_;
}

void DistanceGrid::filter() {
  const std::size_t nx = nodes_.counts[0], ny = nodes_.counts[1], nz = nodes_.counts[2];
  std::vector<double> line(std::max({nx, ny, nz}));
  const auto along = [&](std::size_t count, std::size_t stride, const auto& starts) {
    const std::vector<double> pivots = filter_pivots(count);
    starts([&](std::size_t start) {
      filter_line(coefficients_.data() + start, count, stride, pivots, line);
    });
  };
  along(nx, 1, [&](const auto& line_at) {
    for (std::size_t r = 0; r < ny * nz; ++r) line_at(r * nx);
  });
  along(ny, nx, [&](const auto& line_at) {
    for (std::size_t k = 0; k < nz; ++k)
      for (std::size_t i = 0; i < nx; ++i) line_at(k * nx * ny + i);
  });
  along(nz, nx * ny, [&](const auto& line_at) {
    for (std::size_t c = 0; c < nx * ny; ++c) line_at(c);
  });
}

DistanceGrid::Sample DistanceGrid::at(const Eigen::Vector3d& x) const {
  const Eigen::Vector3d inside = x.cwiseMax(box_.low).cwiseMin(box_.high);
  Stencil stencils[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double u = (inside[axis] - nodes_.origin[axis]) / nodes_.spacing;
    const double last = nodes_.counts[axis] - 1.0;
    // This order of arguments also keeps NaN inside.
    stencils[axis] = stencil_at(u > 0.0 ? std::min(u, last) : 0.0, nodes_.counts[axis]);
  }
  const auto& [sx, sy, sz] = stencils;
  const std::size_t row = nodes_.counts[0], layer = row * nodes_.counts[1];
  const float* corner = coefficients_.data() + sx.first + row * sy.first + layer * sz.first;
  double value = 0.0, along_x = 0.0, along_y = 0.0, along_z = 0.0;
  for (int k = 0; k < 3; ++k) {
    double v = 0.0, dx = 0.0, dy = 0.0;
    for (int j = 0; j < 3; ++j) {
      const float* c = corner + j * row + k * layer;
      const double in_row = sx.value[0] * c[0] + sx.value[1] * c[1] + sx.value[2] * c[2];
      v += sy.value[j] * in_row;
      dy += sy.slope[j] * in_row;
      dx += sy.value[j] * (sx.slope[0] * c[0] + sx.slope[1] * c[1] + sx.slope[2] * c[2]);
    }
    value += sz.value[k] * v;
    along_x += sz.value[k] * dx;
    along_y += sz.value[k] * dy;
    along_z += sz.slope[k] * v;
  }
  Sample sample{value, Eigen::Vector3d(along_x, along_y, along_z) / nodes_.spacing};
  const Eigen::Vector3d beyond = x - inside;
  if (beyond.isZero(0.0)) return sample;
  const double far = beyond.stableNorm();
  sample.distance += far;
  for (int axis = 0; axis < 3; ++axis)
    if (beyond[axis] != 0.0) sample.gradient[axis] = beyond[axis] / far;
  return sample;
}

std::uint64_t DistanceGrid::content_hash() const {
  Hasher hasher;
  const std::array<double, 4> frame = {nodes_.origin.x(), nodes_.origin.y(), nodes_.origin.z(),
                                       nodes_.spacing};
  hasher.add(std::as_bytes(std::span(frame)));
  hasher.add(std::as_bytes(std::span(nodes_.counts)));
  hasher.add(std::as_bytes(std::span(coefficients_)));
  return hasher.hash();
}

}  // namespace tremolo
