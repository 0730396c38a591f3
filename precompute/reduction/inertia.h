// Stage "inertia": the integrals that couple a body to a frame that moves (docs/theory.md, section
// "A body in a world").
#pragma once

#include "common/energy.h"
#include "formats/basis/basis_data.h"
#include "precompute/fem/assembly.h"

namespace tremolo {

// Returns s, A and B of `basis` over the first `count` elements of this rank's part, as a sum over
// ranks. basis: 3n x r at the part's vertices, control values. local: the vertices whose point
// masses count here. Collective.
InertiaIntegrals basis_inertia(const Solid& solid, std::size_t count, const LocalDofs& local,
                               const BasisRows& basis, MassKind kind);

// Fills mass and moments of the rest shape, those of fixed vertices included. whole: the whole
// mesh.
void add_rest_moments(const Solid& whole, MassKind kind, InertiaIntegrals& inertia);

}  // namespace tremolo
