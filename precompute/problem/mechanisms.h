// Motions without strain, found before anything is solved: what of a mesh can still move rigidly.
//
// Tetrahedra joined by faces are a rigid piece. Pieces that share one vertex turn about it (a ball
// joint, three motions), those that share an edge or vertices on a line turn about that (a hinge,
// one), three shared vertices off a line make them one. With a velocity t and a turn w for each
// piece, equal velocities at shared vertices and none at fixed ones are linear equations; their
// null space, the rigid motions of a free body taken off, is the mechanism.
#pragma once

#include <string>
#include <vector>

#include "common/mesh/mesh_check.h"
#include "common/mesh/tet_mesh.h"

namespace tremolo {

// Tetrahedra connected through faces, numbered by their first tetrahedron.
struct Pieces {
  int count = 0;
  std::vector<int> of_tetrahedron;  // m
};
Pieces rigid_pieces(const TetMesh& mesh);

// Where two pieces, or a piece and what is fixed, are joined and move against each other.
struct Joint {
  int piece = 0;                   // the one that hangs: the smaller of two that both move
  int on = 0;                      // the other; -1: fixed vertices
  std::vector<VertexId> vertices;  // shared; if there are several, on a line, the ends first
  int motions = 0;                 // 1 to 3 independent turns
};

// Of one part of the mesh. motions: independent ones, no less than any joint's; in closed loops
// less than their sum.
struct Mechanism {
  int part = 0;
  int motions = 0;
  std::vector<Joint> joints;
};

// More pieces in a part than this are not looked at (a dense singular value decomposition of six
// columns each): what is singular then shows in the modes.
inline constexpr int kMostPieces = 100;

// fixed: ascending vertex ids. free_body: nothing is held, rigid motion of a whole part is no
// mechanism. Parts of more than kMostPieces pieces are left out.
std::vector<Mechanism> find_mechanisms(const TetMesh& mesh, const MeshReport& report,
                                       const Pieces& pieces, const std::vector<VertexId>& fixed,
                                       bool free_body);

// Throws Failure (kContent) when a part of the mesh can move without strain: it says which piece,
// where it hangs, how it can move and what to do.
void require_no_loose_piece(const TetMesh& mesh, const MeshReport& report,
                            const std::vector<VertexId>& fixed, bool free_body);

// Of a free body of several parts, for the user: what is left out of the basis of each.
std::vector<std::string> rigid_motion_notes(const TetMesh& mesh, const MeshReport& report);

}  // namespace tremolo
