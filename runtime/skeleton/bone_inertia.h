// The inertia integrals of each bone's weighted part of a body (docs/theory.md, "A body on bones"):
// those of common/inertia_integrals.h with rho w_b instead of rho.
#pragma once

#include <vector>

#include "common/inertia_integrals.h"
#include "common/result.h"
#include "formats/basis/basis_data.h"
#include "runtime/skeleton/bone_weights.h"

namespace tremolo {

// A solid with its vertices in two blocks, which together contain each vertex of the mesh once.
struct WeighedSolid {
  const VertexBlock& surface;
  const VertexBlock& interior;
  const MassElements& elements;
  // Of quadratic elements, ascending by point; none of linear ones.
  const std::vector<MeshEdge>& edges;
  const InertiaIntegrals& whole;  // the integrals of the whole solid
};

// One per bone, from the consistent mass matrix of each tetrahedron times the mean of its corners'
// weights. The rounding error of their sum (above all of a compact file) is distributed by mass, so
// that they sum to `whole`. surface, interior: the weights of the blocks' vertices. Errors:
// kContent if the elements name a vertex or an edge that does not exist, or their sum differs from
// `whole` by more than one in a thousand: the body has point masses, or its mass matrix is lumped.
Result<std::vector<InertiaIntegrals>> share_inertia(const WeighedSolid& solid,
                                                    const BoneWeights& surface,
                                                    const BoneWeights& interior);

}  // namespace tremolo
