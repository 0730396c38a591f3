#include "precompute/collider/collider_grid.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "common/parallel.h"
#include "common/text.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

// One row of nodes along x. The sign changes only where the surface is nearer than the next node.
// The first node is on the border, outside.
void fill_distance_row(const SurfaceDistance& surface, const GridNodes& nodes, std::size_t j,
                       std::size_t k, float* row) {
  double last = 0.0;
  bool inside = false;
  for (std::size_t i = 0; i < nodes.counts[0]; ++i) {
    const Vector3d x = nodes.at(i, j, k);
    const double distance = surface.magnitude(x);
    const bool may_change = std::max(distance, last) <= 1.0001 * nodes.spacing;
    if (i > 0 && may_change) inside = surface.is_inside(x);
    row[i] = static_cast<float>(inside ? -distance : distance);
    last = distance;
  }
}

// Sums of the triangles' areas, for a choice by area.
std::vector<double> summed_areas(const SurfaceDistance& surface) {
  std::vector<double> sums;
  double sum = 0.0;
  for (std::size_t t = 0; t < surface.triangle_count(); ++t) {
    const auto& [a, b, c] = surface.corners(t);
    sum += (b - a).cross(c - a).norm();
    sums.push_back(sum);
  }
  return sums;
}

struct SurfacePoint {
  Vector3d x;
  Vector3d normal;  // outwards
};

SurfacePoint random_surface_point(const SurfaceDistance& surface, const std::vector<double>& areas,
                                  std::mt19937_64& random) {
  std::uniform_real_distribution<double> share(0.0, 1.0);
  const double chosen = share(random) * areas.back();
  const std::size_t t = std::min<std::size_t>(
      std::upper_bound(areas.begin(), areas.end(), chosen) - areas.begin(), areas.size() - 1);
  const auto& [a, b, c] = surface.corners(t);
  double u = share(random), v = share(random);
  if (u + v > 1.0) {
    u = 1.0 - u;
    v = 1.0 - v;
  }
  return {a + u * (b - a) + v * (c - a), (b - a).cross(c - a).stableNormalized()};
}

// Distance from the point through the solid to its other side; at most `most`.
double wall_behind(const SurfaceDistance& surface, const SurfacePoint& point, double most) {
  constexpr int kLooks = 8;
  double inside = 0.0, outside = most;
  for (int look = 1; look <= kLooks && outside == most; ++look) {
    const double depth = most * look / kLooks;
    (surface.is_inside(point.x - depth * point.normal) ? inside : outside) = depth;
  }
  if (inside == most) return most;
  for (int halving = 0; halving < 8; ++halving) {
    const double middle = 0.5 * (inside + outside);
    (surface.is_inside(point.x - middle * point.normal) ? inside : outside) = middle;
  }
  return inside;
}

}  // namespace

Result<GridNodes> plan_nodes(const BoundingBox& surface, int cells, double margin) {
  const Vector3d size = surface.high - surface.low;
  const auto plan = [&](int count) {
    GridNodes nodes;
    nodes.spacing = size.maxCoeff() / count;
    const double around = std::max(margin, kLeastMarginCells * nodes.spacing);
    for (int axis = 0; axis < 3; ++axis) {
      const double along = std::ceil((size[axis] + 2.0 * around) / nodes.spacing - 1e-9);
      const double most = kMostGridNodes;  // one more is refused below
      nodes.counts[axis] = static_cast<std::uint32_t>(std::min(along, most)) + 1;
      const double middle = 0.5 * (surface.low[axis] + surface.high[axis]);
      nodes.origin[axis] = middle - 0.5 * nodes.spacing * (nodes.counts[axis] - 1.0);
    }
    return nodes;
  };
  GridNodes nodes = plan(cells);
  const Status status = check(nodes);
  if (status) return nodes;
  int possible = cells - 1;
  while (possible > 0 && !check(plan(possible))) --possible;
  return content_error(text("--cells %d: %s; with this margin up to %d cells are possible", cells,
                            status.error().message.c_str(), possible));
}

std::vector<float> distances_at_nodes(const SurfaceDistance& surface, const GridNodes& nodes,
                                      unsigned threads) {
  std::vector<float> distances(nodes.size());
  const std::size_t row = nodes.counts[0], rows = std::size_t{nodes.counts[1]} * nodes.counts[2];
  parallel_for(rows, threads, [&](std::size_t r) {
    fill_distance_row(surface, nodes, r % nodes.counts[1], r / nodes.counts[1],
                      distances.data() + row * r);
  });
  return distances;
}

GridError measure_error(const SurfaceDistance& surface, const DistanceGrid& grid,
                        unsigned threads) {
  constexpr std::size_t kChunks = 64, kPointsOfChunk = 512;
  const std::vector<double> areas = summed_areas(surface);
  std::vector<double> largest(kChunks, 0.0), squares(kChunks, 0.0);
  parallel_for(kChunks, threads, [&](std::size_t chunk) {
    std::mt19937_64 random(1 + chunk);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    for (std::size_t i = 0; i < kPointsOfChunk; ++i) {
      const SurfacePoint point = random_surface_point(surface, areas, random);
      const double beside = 2.0 * grid.nodes().spacing * (2.0 * share(random) - 1.0);
      const Vector3d x = point.x + beside * point.normal;
      const double error = std::abs(grid.at(x).distance - surface.at(x));
      largest[chunk] = std::max(largest[chunk], error);
      squares[chunk] += error * error;
    }
  });
  GridError error;
  error.points = kChunks * kPointsOfChunk;
  error.largest = *std::max_element(largest.begin(), largest.end());
  double sum = 0.0;
  for (const double square : squares) sum += square;
  error.root_mean_square = std::sqrt(sum / static_cast<double>(error.points));
  return error;
}

double missed_share(const SurfaceDistance& surface, const DistanceGrid& grid, unsigned threads) {
  constexpr std::size_t kChunks = 64, kPointsOfChunk = 64;
  const std::vector<double> areas = summed_areas(surface);
  const double most = 2.0 * grid.nodes().spacing;
  std::vector<std::size_t> missed(kChunks, 0);
  parallel_for(kChunks, threads, [&](std::size_t chunk) {
    std::mt19937_64 random(1001 + chunk);
    for (std::size_t i = 0; i < kPointsOfChunk; ++i) {
      const SurfacePoint point = random_surface_point(surface, areas, random);
      const double wall = wall_behind(surface, point, most);
      if (!(wall < most)) continue;
      const Vector3d middle = point.x - 0.5 * wall * point.normal;
      // Beside an edge another face is nearer: that is rounded off, not missed.
      const bool between = surface.magnitude(middle) > 0.35 * wall;
      if (between && grid.at(middle).distance >= 0.0) ++missed[chunk];
    }
  });
  const double sum = static_cast<double>(std::accumulate(missed.begin(), missed.end(), 0UL));
  return sum / (kChunks * kPointsOfChunk);
}

}  // namespace tremolo
