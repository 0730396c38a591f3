#include "precompute/mesher/surface_outcome.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "precompute/mesher/surface_distance.h"

namespace tremolo {
namespace {

using Point = Eigen::Vector3d;

constexpr std::size_t kDistanceSamples = 20'000;
// A part with less than this share of the largest one's volume is a crumb.
constexpr double kCrumb = 0.01;

SurfaceMesh boundary_of(const TetMesh& mesh) {
  const BoundarySurface boundary = boundary_surface(mesh);
  SurfaceMesh surface;
  for (const VertexId v : boundary.vertex_ids)
    surface.vertices.push_back(mesh.vertices[static_cast<std::size_t>(v)]);
  surface.triangles = boundary.triangles;
  return surface;
}

// The largest distance from the mesh's boundary to the surface. Where a hole was closed there is no
// surface: there the solid angle goes steadily through one half, and only there.
double mesh_to_surface(const SurfaceSolid& solid, const SurfaceMesh& boundary, double error,
                       double& largest_cap) {
  const double step = 3.0 * error;
  double largest = 0;
  for (const SurfacePoint& at : spread_points(boundary, kDistanceSamples)) {
    const double distance = solid.tree.nearest(at.point).distance;
    if (!solid.closed && distance > error) {
      const Point normal = doubled_area(boundary, boundary.triangles[at.triangle]).normalized();
      const double before = solid.winding.at(at.point + step * normal);
      const double behind = solid.winding.at(at.point - step * normal);
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

// The way back, from those points of the surface that part inside from outside. Shells that were
// left out as a whole do not count.
double surface_to_mesh(const SurfaceSolid& solid, const TriangleTree& boundary) {
  constexpr double kStep = 1e-4;
  struct Range {
    double least = HUGE_VAL, most = 0;
  };
  std::map<std::size_t, Range> shells;
  for (const SurfacePoint& at : spread_points(solid.surface, kDistanceSamples)) {
    const Point normal =
        doubled_area(solid.surface, solid.surface.triangles[at.triangle]).normalized();
    const bool border =
        solid.inside(at.point - kStep * normal) && !solid.inside(at.point + kStep * normal);
    if (!solid.closed && !border) continue;
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
  std::vector<VertexId> root(mesh.vertices.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&root](VertexId v) {
    while (root[static_cast<std::size_t>(v)] != v)
      v = root[static_cast<std::size_t>(v)] =
          root[static_cast<std::size_t>(root[static_cast<std::size_t>(v)])];
    return v;
  };
  for (const Tetrahedron& t : mesh.tetrahedra)
    for (std::size_t i = 1; i < 4; ++i) root[static_cast<std::size_t>(find(t[i]))] = find(t[0]);
  std::map<VertexId, double> volumes;
  for (const Tetrahedron& t : mesh.tetrahedra) volumes[find(t[0])] += signed_volume(mesh, t);
  double largest = 0;
  for (const auto& [part, value] : volumes) largest = std::max(largest, value);
  PartCounts parts;
  std::vector<bool> stays(mesh.vertices.size(), false);
  for (const auto& [part, value] : volumes) {
    stays[static_cast<std::size_t>(part)] = keep || value >= kCrumb * largest;
    ++(stays[static_cast<std::size_t>(part)] ? parts.kept : parts.dropped);
  }
  TetMesh result;
  std::vector<VertexId> place(mesh.vertices.size(), -1);
  for (const Tetrahedron& t : mesh.tetrahedra) {
    if (!stays[static_cast<std::size_t>(find(t[0]))]) continue;
    Tetrahedron moved{};
    for (std::size_t i = 0; i < 4; ++i) {
      VertexId& to = place[static_cast<std::size_t>(t[i])];
      if (to < 0) {
        to = static_cast<VertexId>(result.vertices.size());
        result.vertices.push_back(mesh.vertices[static_cast<std::size_t>(t[i])]);
      }
      moved[i] = to;
    }
    result.tetrahedra.push_back(moved);
  }
  mesh = std::move(result);
  return parts;
}

SurfaceDistances measure_distances(const SurfaceSolid& solid, double error, const TetMesh& mesh) {
  const SurfaceMesh boundary = boundary_of(mesh);
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
