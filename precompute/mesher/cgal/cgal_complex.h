// Common part of the two meshers: quality bounds, sizes, the watch over refinement, and reading a
// result from CGAL.
#pragma once

#include <functional>
#include <unordered_map>
#include <vector>

#include <CGAL/Random.h>
#include <CGAL/refine_mesh_3.h>

#include "common/mesh/tet_mesh.h"
#include "precompute/mesher/cgal/cgal_mesher.h"

namespace tremolo {

// Smallest angle of a surface triangle, degrees. Refinement is proved to end up to 30.
inline constexpr double kFacetAngle = 27.0;
// Circumradius over shortest edge of a tetrahedron. Refinement is proved to end above 2.
inline constexpr double kRadiusEdge = 2.2;
// Tetrahedra whose smallest dihedral angle is below this many degrees are improved; thin members
// keep some below it. A higher bound costs time and helps little.
inline constexpr double kSliverBound = 15.0;

// CGAL's random numbers begin with it, so that the same input gives the same mesh.
inline constexpr unsigned kSeed = 1;

// A size for Mesh_3: the requested edge length at a point.
template <class Domain>
struct Sizing {
  using FT = double;
  using Index = typename Domain::Index;
  const std::function<double(const Eigen::Vector3d&)>* size;
  template <class AnyPoint>
  FT operator()(const AnyPoint& p, int /*dimension*/, const Index& /*index*/) const {
    return (*size)({p.x(), p.y(), p.z()});
  }
};

// A Mesh_complex_3_in_triangulation_3 that counts by `watch`, if there is one, each query whether a
// facet is part of the surface: every step of refinement makes some.
template <class Plain>
class WatchedComplex : public Plain {
 public:
  bool is_in_complex(const typename Plain::Facet& facet) const {
    if (watch != nullptr) watch->step(this->triangulation().number_of_vertices());
    return Plain::is_in_complex(facet);
  }
  template <class... Others>
  bool is_in_complex(const Others&... others) const {
    return Plain::is_in_complex(others...);
  }

  RefinementWatch* watch = nullptr;
};

// CGAL's exudation of slivers. It inserts no vertices and ends soon, so that nothing bounds it.
template <class Complex>
void exude(Complex& complex) {
  RefinementWatch unbounded({});
  complex.watch = &unbounded;
  CGAL::exude_mesh_3(complex, CGAL::parameters::sliver_bound = kSliverBound,
                     CGAL::parameters::time_limit = 0);
  complex.watch = nullptr;
}

// The tetrahedra, positively oriented, in an order that depends on no address. on_edge, if given:
// for each vertex whether it is on an edge or corner that the mesh must keep.
template <class Complex>
TetMesh extract(const Complex& complex, std::vector<bool>* on_edge = nullptr) {
  TetMesh mesh;
  std::unordered_map<std::size_t, VertexId> ids;  // by Mesh_3's time stamp
  for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end();
       ++cell) {
    Tetrahedron tet{};
    for (int i = 0; i < 4; ++i) {
      const auto vertex = cell->vertex(i);
      const auto [found, fresh] =
          ids.try_emplace(vertex->time_stamp(), static_cast<VertexId>(mesh.vertices.size()));
      if (fresh) {
        const auto& p = vertex->point().point();
        mesh.vertices.emplace_back(p.x(), p.y(), p.z());
        if (on_edge != nullptr) on_edge->push_back(complex.in_dimension(vertex) < 2);
      }
      tet[i] = found->second;
    }
    if (signed_volume(mesh, tet) < 0.0) std::swap(tet[2], tet[3]);
    mesh.tetrahedra.push_back(tet);
  }
  return mesh;
}

}  // namespace tremolo
