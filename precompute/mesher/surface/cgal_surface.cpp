#include "precompute/mesher/surface/cgal_surface.h"

#include <CGAL/Polygon_mesh_processing/polygon_mesh_to_polygon_soup.h>

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
