#include "precompute/mesher/surface/surface_solid.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "common/mesh/mesh_check.h"
#include "precompute/mesher/surface/surface_geometry.h"

namespace tremolo {
namespace {

using Point = Eigen::Vector3d;

constexpr std::size_t kVolumeSamples = 40'000;

}  // namespace

SurfaceMesh scale(const RenderSurface& given, Scaling& scaling) {
  std::vector<Point> used;
  for (const Triangle& t : given.triangles)
    for (const VertexId v : t) used.push_back(given.vertices[v]);
  const BoundingBox box = bounding_box(used);
  scaling.centre = 0.5 * (box.low + box.high);
  scaling.diagonal = box.diagonal();
  SurfaceMesh surface;
  if (!(scaling.diagonal > 0)) return surface;
  surface.triangles = given.triangles;
  for (const Point& x : given.vertices) surface.vertices.push_back(scaling.in(x));
  return surface;
}

SurfaceSolid::SurfaceSolid(RepairedSurface repaired, double thickness)
    : surface(std::move(repaired.mesh)),
      shell_of(std::move(repaired.shell_of)),
      tree(surface),
      winding(surface),
      half_thickness(0.5 * thickness),
      closed(repaired.findings.clean()) {}

bool SurfaceSolid::inside(const Point& x) const {
  if (half_thickness > 0) return tree.nearest(x).distance < half_thickness;
  return winding.at(x) > 0.5;
}

Openness openness(const SurfaceSolid& solid) {
  constexpr std::size_t kPoints = 2'000;
  constexpr double kStep = 1e-5;
  Openness result;
  for (const SurfacePoint& at : spread_points(solid.surface, kPoints)) {
    const double behind = solid.winding.at(at.point - kStep * at.normal);
    result.backed += behind > 0.5;
    result.lacking += std::clamp(1.0 - behind, 0.0, 1.0);
  }
  result.backed /= kPoints;
  result.lacking /= kPoints;
  return result;
}

namespace {

bool has_exact_volume(const SurfaceSolid& solid) {
  return solid.closed && solid.half_thickness == 0;
}

// In which the volume is sampled.
BoundingBox box_around(const SurfaceSolid& solid) {
  BoundingBox box = bounding_box(solid.surface.vertices);
  box.low.array() -= solid.half_thickness;
  box.high.array() += solid.half_thickness;
  return box;
}

}  // namespace

double volume(const SurfaceSolid& solid) {
  if (has_exact_volume(solid)) {
    double sum = 0;
    for (const Triangle& t : solid.surface.triangles) sum += volume_below(solid.surface, t);
    return sum;
  }
  const BoundingBox box = box_around(solid);
  const Point extent = box.high - box.low;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::size_t hits = 0;
  for (std::size_t i = 0; i < kVolumeSamples; ++i) {
    const Point share(uniform(random), uniform(random), uniform(random));
    hits += solid.inside(box.low + share.cwiseProduct(extent));
  }
  return extent.prod() * static_cast<double>(hits) / kVolumeSamples;
}

double volume_deviation(const SurfaceSolid& solid, double volume) {
  if (has_exact_volume(solid)) return 0;
  const BoundingBox box = box_around(solid);
  const double share = volume / (box.high - box.low).prod();
  return std::sqrt(std::max(0.0, 1.0 - share) / (share * kVolumeSamples));
}

namespace {

constexpr std::size_t kDistanceSamples = 20'000;
// A part with less than this share of the largest one's volume is a crumb.
constexpr double kCrumb = 0.01;

// The largest distance from the mesh's boundary to the surface. Where a hole was closed there is no
// surface, and only there the solid angle passes one half gradually; those distances count for
// largest_cap.
double mesh_to_surface(const SurfaceSolid& solid, const SurfaceMesh& boundary, double error,
                       double& largest_cap) {
  const double step = 3.0 * error;
  double largest = 0;
  for (const SurfacePoint& at : spread_points(boundary, kDistanceSamples)) {
    const double distance = solid.tree.nearest(at.point).distance;
    if (!solid.closed && distance > error) {
      const double before = solid.winding.at(at.point + step * at.normal);
      const double behind = solid.winding.at(at.point - step * at.normal);
      constexpr double kSteady = 0.25;
      if (std::abs(before - 0.5) < kSteady && std::abs(behind - 0.5) < kSteady) {
        largest_cap = std::max(largest_cap, distance);
        continue;
      }
    }
    largest = std::max(largest, distance);
  }
  return largest;
}

// True if a point of the surface is between inside and outside. On either side of a fin the winding
// number is one half.
bool is_border(const SurfaceSolid& solid, const SurfacePoint& at) {
  constexpr double kStep = 1e-4;
  constexpr double kBacked = 0.65;
  return solid.winding.at(at.point - kStep * at.normal) > kBacked &&
         !solid.inside(at.point + kStep * at.normal);
}

// The largest distance to the mesh's boundary from the part of the surface between inside and
// outside. Shells that were left out completely are ignored.
double surface_to_mesh(const SurfaceSolid& solid, const TriangleTree& boundary) {
  struct Range {
    double least = HUGE_VAL, most = 0;
  };
  std::map<std::size_t, Range> shells;
  for (const SurfacePoint& at : spread_points(solid.surface, kDistanceSamples)) {
    if (!solid.closed && !is_border(solid, at)) continue;
    const double distance = boundary.nearest(at.point).distance;
    Range& range = shells[solid.shell_of[at.triangle]];
    range.least = std::min(range.least, distance);
    range.most = std::max(range.most, distance);
  }
  double largest = 0;
  for (const auto& [shell, range] : shells)
    if (range.least < kWorstError) largest = std::max(largest, range.most);
  return largest;
}

}  // namespace

PartCounts drop_crumbs(TetMesh& mesh, bool keep) {
  const MeshParts labels = mesh_parts(mesh);
  const auto part_of = [&labels](const Tetrahedron& t) { return labels.part_of_vertex[t[0]]; };
  std::vector<double> volumes(labels.count, 0.0);
  for (const Tetrahedron& t : mesh.tetrahedra) volumes[part_of(t)] += signed_volume(mesh, t);
  const double largest = *std::max_element(volumes.begin(), volumes.end());
  PartCounts parts;
  for (const double volume : volumes)
    ++(keep || volume >= kCrumb * largest ? parts.kept : parts.dropped);
  if (parts.dropped == 0) return parts;
  TetMesh result;
  std::vector<VertexId> place(mesh.vertices.size(), -1);
  for (const Tetrahedron& t : mesh.tetrahedra) {
    if (volumes[part_of(t)] < kCrumb * largest) continue;
    Tetrahedron moved{};
    for (std::size_t i = 0; i < 4; ++i) {
      VertexId& to = place[t[i]];
      if (to < 0) {
        to = static_cast<VertexId>(result.vertices.size());
        result.vertices.push_back(mesh.vertices[t[i]]);
      }
      moved[i] = to;
    }
    result.tetrahedra.push_back(moved);
  }
  mesh = std::move(result);
  return parts;
}

SurfaceDistances measure_distances(const SurfaceSolid& solid, double error, const TetMesh& mesh) {
  const SurfaceMesh boundary = boundary_mesh(mesh);
  const TriangleTree tree(boundary);
  if (solid.half_thickness > 0)
    // The faces of a sheet are half its thickness off on purpose.
    return {distance_from(boundary, solid.tree, kDistanceSamples) - solid.half_thickness,
            distance_from(solid.surface, tree, kDistanceSamples) - solid.half_thickness, 0.0};
  SurfaceDistances distances;
  distances.mesh_to_surface = mesh_to_surface(solid, boundary, error, distances.cap_to_surface);
  distances.surface_to_mesh = surface_to_mesh(solid, tree);
  return distances;
}

}  // namespace tremolo
