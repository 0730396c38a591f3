// Detection of mechanisms, i.e. motions without strain, before anything is solved.
//
// Tetrahedra joined by faces form a rigid piece. Two pieces that share one vertex rotate about it
// (a ball joint, three motions); two that share an edge or vertices on a line rotate about that
// line (a hinge, one motion); three shared vertices off a line join them rigidly. Each piece has a
// velocity t and an angular velocity w. Equal velocities at shared vertices and zero velocity at
// fixed ones are linear equations; their null space, without the rigid motions of a free body, is
// the mechanism.
#pragma once

#include <string>
#include <vector>

#include "common/mesh/mesh_check.h"
#include "common/mesh/tet_mesh.h"

namespace tremolo {

// Tetrahedra connected through faces; pieces are numbered by their first tetrahedron.
struct Pieces {
  int count = 0;
  std::vector<int> of_tetrahedron;  // piece of each tetrahedron, m
};
Pieces rigid_pieces(const TetMesh& mesh);

// A place where two pieces, or a piece and fixed vertices, are joined but can move relative to each
// other.
struct Joint {
  int piece = 0;  // the moving piece; the smaller one if both move
  int on = 0;     // the other piece; -1: fixed vertices
  std::vector<VertexId>
      vertices;     // shared vertices; several lie on a line, and its two ends come first
  int motions = 0;  // number of independent rotations, 1 to 3
};

// The mechanism of one part of the mesh. motions: number of independent motions; at least that of
// any joint, and in closed loops less than the sum over the joints.
struct Mechanism {
  int part = 0;
  int motions = 0;
  std::vector<Joint> joints;
};

// Parts with more pieces than this are skipped, since a dense singular value decomposition with six
// columns a piece would be needed; a singular stiffness then shows in the eigensolver.
inline constexpr int kMostPieces = 100;

// fixed: ascending vertex ids. free_body: nothing is held, and rigid motion of a whole part is not
// a mechanism. Parts of more than kMostPieces pieces are skipped.
std::vector<Mechanism> find_mechanisms(const TetMesh& mesh, const MeshReport& report,
                                       const Pieces& pieces, const std::vector<VertexId>& fixed,
                                       bool free_body);

// Throws Failure (kContent) if a part of the mesh can move without strain. The message names the
// piece, its joint, the motion and a remedy.
void require_no_loose_piece(const TetMesh& mesh, const MeshReport& report,
                            const std::vector<VertexId>& fixed, bool free_body);

// Returns notes on the rigid motions that are left out of the basis of each part of a free body.
std::vector<std::string> rigid_motion_notes(const TetMesh& mesh, const MeshReport& report);

}  // namespace tremolo
