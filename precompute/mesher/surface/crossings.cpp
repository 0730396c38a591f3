#include <algorithm>
#include <exception>
#include <numeric>

#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/polygon_mesh_to_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>

#include "precompute/mesher/surface/cgal_surface.h"
#include "precompute/mesher/surface/repair_steps.h"

namespace tremolo {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;

// More would take too long: each is united with all before it.
constexpr std::size_t kMostShells = 200;

// The union of the shells; may throw CGAL's exceptions.
std::optional<cgal::SurfaceMesh> unite(const std::vector<SurfaceMesh>& shells) {
  cgal::SurfaceMesh all;
  for (const SurfaceMesh& shell : shells) {
    if (shell.triangles.empty()) continue;
    cgal::SurfaceMesh mesh;
    if (!cgal::copy(shell, mesh) || !CGAL::is_closed(mesh) || PMP::does_self_intersect(mesh) ||
        PMP::volume(mesh) <= 0)
      return std::nullopt;
    if (all.is_empty())
      all = mesh;
    else if (!PMP::corefine_and_compute_union(all, mesh, all))
      return std::nullopt;
  }
  return all;
}

// Sorts vertices and triangles by position, since corefinement's order depends on addresses, and
// the mesh on that order.
void sort_by_place(SurfaceMesh& surface) {
  std::vector<std::size_t> order(surface.vertices.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&surface](std::size_t i, std::size_t j) {
    const Eigen::Vector3d &a = surface.vertices[i], &b = surface.vertices[j];
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  });
  std::vector<Eigen::Vector3d> vertices;
  std::vector<VertexId> new_ids(order.size());
  for (const std::size_t v : order) {
    new_ids[v] = static_cast<VertexId>(vertices.size());
    vertices.push_back(surface.vertices[v]);
  }
  surface.vertices = std::move(vertices);
  for (Triangle& t : surface.triangles) {
    for (VertexId& v : t) v = new_ids[v];
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  }
  std::sort(surface.triangles.begin(), surface.triangles.end());
}

}  // namespace

std::size_t count_crossings(const SurfaceMesh& surface) {
  cgal::SurfaceMesh mesh;
  // CGAL refuses triangles that meet only in a corner, where the surface touches itself.
  if (!cgal::copy(surface, mesh)) return 1;
  std::vector<std::pair<cgal::SurfaceMesh::Face_index, cgal::SurfaceMesh::Face_index>> pairs;
  PMP::self_intersections(mesh, std::back_inserter(pairs));
  return pairs.size();
}

std::optional<SurfaceMesh> unite_shells(const SurfaceMesh& surface,
                                        const std::vector<std::size_t>& shell_of) {
  std::size_t count = 0;
  for (const std::size_t shell : shell_of) count = std::max(count, shell + 1);
  if (count < 2 || count > kMostShells) return std::nullopt;
  std::vector<SurfaceMesh> shells(count, {surface.vertices, {}});
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    shells[shell_of[t]].triangles.push_back(surface.triangles[t]);
  for (SurfaceMesh& shell : shells) drop_unused_vertices(shell);
  try {
    const std::optional<cgal::SurfaceMesh> all = unite(shells);
    if (!all) return std::nullopt;
    SurfaceMesh united = cgal::copy(*all);
    weld(united);
    sort_by_place(united);
    if (odd_edges(united) > 0 || count_crossings(united) > 0) return std::nullopt;
    return united;
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

}  // namespace tremolo

namespace tremolo::cgal {

bool copy(const tremolo::SurfaceMesh& surface, SurfaceMesh& out) {
  std::vector<SurfaceMesh::Vertex_index> vertices;
  for (const Eigen::Vector3d& x : surface.vertices)
    vertices.push_back(out.add_vertex(Kernel::Point_3(x[0], x[1], x[2])));
  const auto at = [&](VertexId v) { return vertices[v]; };
  for (const Triangle& t : surface.triangles)
    if (out.add_face(at(t[0]), at(t[1]), at(t[2])) == SurfaceMesh::null_face()) return false;
  return true;
}

tremolo::SurfaceMesh copy(const SurfaceMesh& mesh) {
  tremolo::SurfaceMesh surface;
  std::vector<std::array<double, 3>> points;
  CGAL::Polygon_mesh_processing::polygon_mesh_to_polygon_soup(mesh, points, surface.triangles);
  for (const auto& [x, y, z] : points) surface.vertices.emplace_back(x, y, z);
  return surface;
}

}  // namespace tremolo::cgal
