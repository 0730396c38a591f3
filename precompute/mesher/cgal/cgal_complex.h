// What the two meshers share: how well, what watches over refinement, and how a result is read out
// of CGAL.
#pragma once

#include <unordered_map>
#include <vector>

#include "common/mesh/tet_mesh.h"
#include "precompute/mesher/cgal/refinement_watch.h"

namespace tremolo {

// Smallest angle of a surface triangle, degrees. Refinement is proved to end up to 30.
inline constexpr double kFacetAngle = 27.0;
// Circumradius over shortest edge of a tetrahedron. Refinement is proved to end above 2.
inline constexpr double kRadiusEdge = 2.2;
// Tetrahedra whose smallest dihedral angle is below this many degrees are worked on; thin members
// keep some below it. Higher costs time and helps little.
inline constexpr double kSliverBound = 15.0;

// A Mesh_complex_3_in_triangulation_3 that tells `watch`, if there is one, of each question whether
// a facet is of the surface: whatever refinement does, it asks that.
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

// Positively oriented, in an order that depends on no address. on_edge, if given: one a vertex,
// true where it stands on an edge or corner that the mesh must keep.
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
      tet[static_cast<std::size_t>(i)] = found->second;
    }
    if (signed_volume(mesh, tet) < 0.0) std::swap(tet[2], tet[3]);
    mesh.tetrahedra.push_back(tet);
  }
  return mesh;
}

}  // namespace tremolo
