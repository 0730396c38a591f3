#include "precompute/mesher/cgal/size_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "precompute/mesher/surface/surface_geometry.h"

namespace tremolo {
namespace {

using Point = Eigen::Vector3d;

constexpr double kGrowth = 0.5;
constexpr int kCells = 72;  // along the longest side
// Rays behind a sample besides the straight one; they are on a cone, so that a notch is ignored.
constexpr int kConeRays = 4;
// Cosine between the normals of two sides of a wall.
constexpr double kParallel = 0.8;
constexpr double kCone = 30.0 * std::numbers::pi / 180.0;
// Volume of a tetrahedron over the cube of the requested edge, as measured for this mesher.
constexpr double kVolumePerCube = 0.2;
// The number of triangles within the solid that a ray may pass, and the distance behind each at
// which it continues; surfaces are scaled to a diagonal of 1.
constexpr int kMostHits = 8;
constexpr double kPassing = 1e-6;
constexpr std::size_t kNoTriangle = static_cast<std::size_t>(-1);

// Finds where a ray leaves the solid; it passes triangles that lie within the solid.
Hit way_out(const TriangleTree& tree, const Inside& inside, const Point& x, const Point& direction,
            std::size_t triangle) {
  Hit way = tree.first_hit(x, direction, triangle);
  for (int hit = 0; inside && hit < kMostHits && std::isfinite(way.distance); ++hit) {
    const Point behind = x + (way.distance + kPassing) * direction;
    if (!inside(behind)) break;
    const Hit next = tree.first_hit(behind, direction, kNoTriangle);
    way = {way.distance + kPassing + next.distance, next.triangle};
  }
  return way;
}

// The thickness of the solid behind a point; infinite if the solid does not end there or ends at no
// wall: at the edge of a wedge the two sides are close to each other but not parallel.
double thickness_behind(const SurfaceMesh& surface, const TriangleTree& tree, const Inside& inside,
                        const SurfacePoint& at) {
  const Point inwards = -at.normal;
  const Hit straight = way_out(tree, inside, at.point, inwards, at.triangle);
  if (!std::isfinite(straight.distance)) return straight.distance;
  const Point far = doubled_area(surface, surface.triangles[straight.triangle]).normalized();
  if (std::abs(far.dot(inwards)) < kParallel) return HUGE_VAL;
  std::vector<double> lengths{straight.distance};
  const Point side = inwards.unitOrthogonal();
  const Point other = inwards.cross(side);
  for (int i = 0; i < kConeRays; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / kConeRays;
    const Point direction = std::cos(kCone) * inwards +
                            std::sin(kCone) * (std::cos(turn) * side + std::sin(turn) * other);
    lengths.push_back(std::cos(kCone) *
                      way_out(tree, inside, at.point, direction, at.triangle).distance);
  }
  std::nth_element(lengths.begin(), lengths.begin() + 2, lengths.end());
  return lengths[2];
}

// From the lowest corner of a cell to one of its eight.
Eigen::Vector3i corner_offset(int corner) {
  return {corner % 2, corner / 2 % 2, corner / 4};
}

}  // namespace

std::vector<WallSample> wall_samples(const SurfaceMesh& surface, const TriangleTree& tree,
                                     const Inside& inside, std::size_t count) {
  const double share = area(surface) / static_cast<double>(count);
  std::vector<WallSample> samples;
  for (const SurfacePoint& at : spread_points(surface, count)) {
    if (inside &&
        (inside(at.point + kPassing * at.normal) || !inside(at.point - kPassing * at.normal)))
      continue;
    const double thickness = thickness_behind(surface, tree, inside, at);
    if (std::isfinite(thickness) && thickness > 0) samples.push_back({at.point, thickness, share});
  }
  return samples;
}

SizeField::SizeField(const BoundingBox& box, const std::vector<WallSample>& walls, double coarse,
                     double fine)
    : coarse_(coarse) {
  step_ = (box.high - box.low).maxCoeff() / kCells;
  low_ = box.low - Point::Constant(step_);
  count_ = ((box.high - box.low) / step_).array().ceil().cast<int>() + 4;
  values_.assign(count_.prod(), static_cast<float>(coarse));
  for (const WallSample& wall : walls) {
    const double size = std::clamp(wall.thickness, fine, coarse);
    const Eigen::Vector3i cell = ((wall.point - low_) / step_).array().floor().cast<int>();
    for (int corner = 0; corner < 8; ++corner) {
      float& value = values_[index(cell + corner_offset(corner))];
      value = std::min(value, static_cast<float>(size));
    }
  }
  // Sweeps in all eight directions bound the growth from a node to its neighbours along the axes.
  const auto slope = static_cast<float>(kGrowth * step_);
  for (int sweep = 0; sweep < 8; ++sweep) {
    const Eigen::Vector3i sign(sweep & 1 ? -1 : 1, sweep & 2 ? -1 : 1, sweep & 4 ? -1 : 1);
    Eigen::Vector3i at;
    for (int k = 0; k < count_[2]; ++k)
      for (int j = 0; j < count_[1]; ++j)
        for (int i = 0; i < count_[0]; ++i) {
          at = {sign[0] > 0 ? i : count_[0] - 1 - i, sign[1] > 0 ? j : count_[1] - 1 - j,
                sign[2] > 0 ? k : count_[2] - 1 - k};
          float& value = values_[index(at)];
          for (int axis = 0; axis < 3; ++axis) {
            Eigen::Vector3i before = at;
            before[axis] -= sign[axis];
            if (before[axis] < 0 || before[axis] >= count_[axis]) continue;
            value = std::min(value, values_[index(before)] + slope);
          }
        }
  }
}

double SizeField::at(const Point& x) const {
  const Point place = (x - low_) / step_;
  Eigen::Vector3i cell;
  Point share;
  for (int axis = 0; axis < 3; ++axis) {
    const double inside = std::clamp(place[axis], 0.0, static_cast<double>(count_[axis]) - 1.001);
    cell[axis] = static_cast<int>(inside);
    share[axis] = inside - cell[axis];
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3i offset = corner_offset(corner);
    const auto weight = [&](int axis) { return offset[axis] ? share[axis] : 1 - share[axis]; };
    sum += weight(0) * weight(1) * weight(2) * values_[index(cell + offset)];
  }
  return sum;
}

double size_for_count(double volume, double count) {
  return std::cbrt(volume / (kVolumePerCube * count));
}

double estimated_count(const std::vector<WallSample>& walls, double volume, double coarse,
                       double fine) {
  double behind = 0;
  for (const WallSample& wall : walls) behind += wall.area * wall.thickness;
  if (!(behind > 0)) return volume / (kVolumePerCube * coarse * coarse * coarse);
  double count = 0;
  for (const WallSample& wall : walls) {
    const double size = std::clamp(wall.thickness, fine, coarse);
    count += volume * wall.area * wall.thickness / behind / (kVolumePerCube * size * size * size);
  }
  return count;
}

}  // namespace tremolo
