#include "precompute/mesher/surface/mesh_likeness.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "common/mesh/mesh_quality.h"

namespace tremolo {
namespace {

constexpr double kLost = 0.25, kPoor = 0.02;
// Standard deviations by which an estimated volume may be off.
constexpr double kDeviations = 4;

using CornerPair = std::pair<VertexId, VertexId>;

// Labels of the triangles that are joined by edges with exactly two triangles: cubes that touch in
// an edge or a corner count as two.
std::vector<std::size_t> joined_triangles(const SurfaceMesh& surface) {
  std::map<CornerPair, std::vector<std::size_t>> around;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] =
          std::minmax(surface.triangles[t][k], surface.triangles[t][(k + 1) % 3]);
      around[{low, high}].push_back(t);
    }
  std::vector<std::size_t> label(surface.triangles.size());
  std::iota(label.begin(), label.end(), std::size_t{0});
  const auto root = [&label](std::size_t t) {
    while (label[t] != t) t = label[t] = label[label[t]];
    return t;
  };
  for (const auto& [edge, triangles] : around)
    if (triangles.size() == 2) label[root(triangles[0])] = root(triangles[1]);
  for (std::size_t t = 0; t < label.size(); ++t) label[t] = root(t);
  return label;
}

// Of a closed surface the shells that face outwards; others are cavities.
std::size_t most_parts(const SurfaceSolid& solid) {
  const std::vector<std::size_t> label = joined_triangles(solid.surface);
  std::map<std::size_t, double> volumes;
  for (std::size_t t = 0; t < label.size(); ++t)
    volumes[label[t]] += volume_below(solid.surface, solid.surface.triangles[t]);
  if (!solid.closed || solid.half_thickness > 0) return volumes.size();
  return std::count_if(volumes.begin(), volumes.end(),
                       [](const auto& entry) { return entry.second > 0; });
}

}  // namespace

bool Likeness::is_lost() const {
  return std::abs(volume_share - 1.0) > kLost + unsure || parts > most_parts;
}

bool Likeness::is_poor() const {
  return std::abs(volume_share - 1.0) > kPoor + unsure;
}

Likeness compare_with_solid(const SurfaceSolid& solid, double solid_volume, const TetMesh& mesh) {
  const MeshQuality quality = mesh_quality(mesh);
  Likeness likeness;
  likeness.parts = quality.parts;
  likeness.most_parts = most_parts(solid);
  // An estimate without a hit says nothing.
  if (!(solid_volume > 0)) return likeness;
  likeness.volume_share = quality.volume / solid_volume;
  likeness.unsure = kDeviations * volume_deviation(solid, solid_volume);
  return likeness;
}

}  // namespace tremolo
