#include "precompute/mesher/surface/crossings.h"

#include <vector>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>

#include "precompute/mesher/surface/cgal_surface.h"

namespace tremolo {

std::size_t count_crossings(const SurfaceMesh& surface) {
  cgal::SurfaceMesh mesh;
  // A vertex where several fans meet is split by the caller of CGAL; a triangle it refuses shares a
  // corner in a way that only a self-touching surface does.
  if (!cgal::copy(surface, mesh)) return 1;
  std::vector<std::pair<cgal::SurfaceMesh::Face_index, cgal::SurfaceMesh::Face_index>> pairs;
  CGAL::Polygon_mesh_processing::self_intersections(mesh, std::back_inserter(pairs));
  return pairs.size();
}

}  // namespace tremolo
