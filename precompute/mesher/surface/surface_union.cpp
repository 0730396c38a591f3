#include "precompute/mesher/surface/surface_union.h"

#include <algorithm>
#include <exception>

#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>

#include "precompute/mesher/surface/cgal_surface.h"
#include "precompute/mesher/surface/crossings.h"
#include "precompute/mesher/surface/surface_weld.h"

namespace tremolo {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;

// More would take too long: each is united with all before it.
constexpr std::size_t kMostShells = 200;

SurfaceMesh plain(const cgal::SurfaceMesh& mesh) {
  SurfaceMesh surface;
  std::vector<VertexId> place(mesh.num_vertices() + mesh.number_of_removed_vertices(), -1);
  for (const auto v : mesh.vertices()) {
    place[v.idx()] = static_cast<VertexId>(surface.vertices.size());
    const auto& p = mesh.point(v);
    surface.vertices.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto f : mesh.faces()) {
    Triangle t{};
    std::size_t i = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) t[i++] = place[v.idx()];
    surface.triangles.push_back(t);
  }
  return surface;
}

}  // namespace

std::optional<SurfaceMesh> unite_shells(const SurfaceMesh& surface,
                                        const std::vector<std::size_t>& shell_of) {
  std::size_t shells = 0;
  for (const std::size_t shell : shell_of) shells = std::max(shells, shell + 1);
  if (shells < 2 || shells > kMostShells) return std::nullopt;
  std::vector<SurfaceMesh> parts(shells);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    parts[shell_of[t]].triangles.push_back(surface.triangles[t]);
  try {
    cgal::SurfaceMesh all;
    for (SurfaceMesh& part : parts) {
      if (part.triangles.empty()) continue;
      part.vertices = surface.vertices;
      drop_unused_vertices(part);
      cgal::SurfaceMesh mesh;
      if (!cgal::copy(part, mesh) || !CGAL::is_closed(mesh) || PMP::does_self_intersect(mesh) ||
          PMP::volume(mesh) <= 0)
        return std::nullopt;
      if (all.is_empty())
        all = mesh;
      else if (!PMP::corefine_and_compute_union(all, mesh, all))
        return std::nullopt;
    }
    SurfaceMesh united = plain(all);
    weld(united);
    if (odd_edges(united) > 0 || count_crossings(united) > 0) return std::nullopt;
    return united;
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

}  // namespace tremolo
