// The inertia integrals of the share of a body that each bone carries (docs/theory.md, "A body on
// bones"): those of common/inertia_integrals.h with rho w_b in place of rho.
#pragma once

#include <vector>

#include "common/inertia_integrals.h"
#include "common/result.h"
#include "formats/basis/basis_data.h"
#include "runtime/skeleton/bone_weights.h"

namespace tremolo {

// A solid with its vertices in two blocks, which hold each vertex of the mesh once. edges: of
// quadratic elements, ascending by point; none of linear ones. whole: the integrals of all of it.
struct WeighedSolid {
  const VertexBlock& surface;
  const VertexBlock& interior;
  const MassElements& elements;
  const std::vector<MeshEdge>& edges;
  const InertiaIntegrals& whole;
};

// One a bone, from the consistent mass matrix of each tetrahedron times the mean of its corners'
// weights. What rounding (a compact file's above all) leaves of their sum against `whole` is
// shared by mass, so that they sum to it. surface, interior: the weights of the blocks' vertices.
// Errors: kContent if the elements name a vertex or an edge that is not there, or do not sum to
// `whole` to one in a thousand: the body has point masses, or its mass matrix is lumped.
Result<std::vector<InertiaIntegrals>> share_inertia(const WeighedSolid& solid,
                                                    const BoneWeights& surface,
                                                    const BoneWeights& interior);

}  // namespace tremolo
