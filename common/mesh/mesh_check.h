// Checks a tetrahedral mesh: repairs orientation, refuses meshes that cannot be computed with.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/mesh/tet_mesh.h"
#include "common/result.h"

namespace tremolo {

// A tetrahedron is degenerate if its volume is at most this times its longest edge cubed. A regular
// one has 0.118; rounding of coordinates leaves a flat one near 1e-16. Larger values refuse
// slivers that still can be computed with.
inline constexpr double kDegenerateVolume = 1e-12;

// Findings and repairs of check_mesh().
struct MeshReport {
  std::size_t flipped = 0;                // inverted tetrahedra, repaired
  std::size_t unreferenced_vertices = 0;  // kept, belong to no tetrahedron
  std::size_t parts = 0;                  // connected through shared vertices
  std::vector<int> part_of_vertex;        // one per vertex; -1 for unreferenced vertices
  double volume = 0;                      // m^3
  std::vector<std::string> notes;         // a sentence for each thing the user should know
};

// Afterwards all tetrahedra are positively oriented (the last two vertices of inverted ones are
// swapped). Parts are numbered by their first vertex. Errors (kContent; the mesh is as it was) name
// the first few elements or vertices and how many there are: no tetrahedra, coordinates that are
// not finite, indices out of range (also in node sets and regions), repeated vertices in a
// tetrahedron, degenerate tetrahedra, two tetrahedra with the same four vertices, inverted ones on
// the same side of a face as their neighbour (a mesh that was folded). Elements and vertices count
// from 0.
Result<MeshReport> check_mesh(TetMesh& mesh);

// part_of_vertex: n labels, -1 for vertices of no tetrahedron; parts are connected through shared
// vertices and numbered by their smallest vertex.
struct MeshParts {
  std::size_t count = 0;
  std::vector<int> part_of_vertex;
};

// Indices must be in range.
MeshParts mesh_parts(const TetMesh& mesh);

// Vertices at one position: parts of a mesh that were meshed or written separately have the nodes
// of their common faces twice.

// Vertices of tetrahedra (edge points included) are at one position if they are within this
// fraction of the mesh's diagonal, and within a thousandth of the shortest edge: this includes
// coordinates written with seven digits.
inline constexpr double kCoincident = 1e-6;

// Vertices at the position of another.
struct Coincidences {
  std::size_t pairs = 0;           // vertices at the position of one with a lower number
  std::vector<VertexId> first_at;  // for each vertex the lowest at its position, or itself
};

// Indices of the mesh that do not exist are passed over: check_mesh() names them.
Coincidences find_coincidences(const TetMesh& mesh);

// Makes tetrahedra, edges and sets refer to the lowest of the vertices at one position; the others
// stay, in no tetrahedron, so that all numbers are the file's.
void merge_vertices(const Coincidences& found, TetMesh& mesh);

}  // namespace tremolo
