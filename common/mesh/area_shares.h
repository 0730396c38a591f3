// Distribution of a force on a face over its vertices.
#pragma once

#include <span>
#include <vector>

#include "common/mesh/tet_mesh.h"

namespace tremolo {

// The fraction for each of `chosen` (ids; at least one); the sum is 1. A boundary triangle whose
// three corners are chosen gives a third of its area to each: a uniform traction over the face,
// whose resultant passes through the face's centroid for any mesh. Chosen vertices of no such
// triangle get nothing. Without any such triangle all fractions are equal. vertex_ids: of the
// boundary, ascending; triangles: indices into them; rest: their positions, m.
std::vector<double> area_shares(std::span<const VertexId> chosen,
                                std::span<const VertexId> vertex_ids,
                                std::span<const Triangle> triangles,
                                std::span<const Eigen::Vector3d> rest);

}  // namespace tremolo
