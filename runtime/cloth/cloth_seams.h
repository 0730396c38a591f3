// Seams of a cloth's mesh: borders at which its file has the same vertices twice.
#pragma once

#include <vector>

#include "common/mesh/surface_mesh.h"

namespace tremolo {

// mesh: with the joined vertices. particle_of: for each vertex before, its number in `mesh`.
struct JoinedSeams {
  SurfaceMesh mesh;
  std::vector<VertexId> particle_of;
};

// Joins boundary vertices (of edges with one triangle) closer than a millionth of the mesh's size.
// Other vertices are not joined: layers may lie on each other. Numbers keep their order.
JoinedSeams join_seams(const SurfaceMesh& mesh);

}  // namespace tremolo
