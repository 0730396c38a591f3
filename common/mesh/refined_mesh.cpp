#include "common/mesh/refined_mesh.h"

#include <utility>

namespace tremolo {
namespace {

// An edge between two opposite ones of the octahedron, and the ring of its other four corners, as
// indices into the edges of a tetrahedron.
struct Diagonal {
  std::array<std::size_t, 2> ends;
  std::array<std::size_t, 4> ring;
};
constexpr std::array<Diagonal, 3> kDiagonals = {
    {{{0, 5}, {1, 2, 4, 3}}, {{1, 4}, {0, 2, 5, 3}}, {{2, 3}, {0, 1, 5, 4}}}};

}  // namespace

TetMesh refined_mesh(const TetMesh& mesh) {
  TetMesh fine;
  fine.vertices = mesh.vertices;
  fine.node_sets = mesh.node_sets;
  fine.colours = mesh.colours;
  fine.region_names = mesh.region_names;
  fine.tetrahedra.reserve(8 * mesh.tetrahedra.size());
  const auto add = [&fine](Tetrahedron tet) {
    if (signed_volume(fine, tet) < 0) std::swap(tet[2], tet[3]);
    fine.tetrahedra.push_back(tet);
  };
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    const Tetrahedron& corner = mesh.tetrahedra[t];
    const TetEdges& edge = mesh.edge_points[t];
    add({corner[0], edge[0], edge[1], edge[2]});
    add({edge[0], corner[1], edge[3], edge[4]});
    add({edge[1], edge[3], corner[2], edge[5]});
    add({edge[2], edge[4], edge[5], corner[3]});
    const Diagonal* shortest = nullptr;
    double least = 0;
    for (const Diagonal& each : kDiagonals) {
      const double length =
          (mesh.vertices[edge[each.ends[0]]] - mesh.vertices[edge[each.ends[1]]]).squaredNorm();
      if (shortest != nullptr && length >= least) continue;
      shortest = &each;
      least = length;
    }
    for (std::size_t k = 0; k < 4; ++k)
      add({edge[shortest->ends[0]], edge[shortest->ends[1]], edge[shortest->ring[k]],
           edge[shortest->ring[(k + 1) % 4]]});
    if (!mesh.region_of.empty()) fine.region_of.insert(fine.region_of.end(), 8, mesh.region_of[t]);
  }
  return fine;
}

}  // namespace tremolo
