// Accuracy checks of the result; an inaccurate one is rejected with the reason.
#pragma once

#include "precompute/modes/modes.h"
#include "precompute/pipeline.h"

namespace tremolo {

// Ratio of stiffnesses above which rounding in the stiff materials affects the soft ones.
inline constexpr double kContrast = 1e6;

// Returns the stiffness of the stiffest material relative to the softest.
double stiffness_ratio(const Solid& solid);

// Throws Failure (kContent) on all ranks if the modes show a mechanism: a hinge or a ball joint
// lets a part move without strain, so that K is singular although enough vertices are fixed, and
// the result of a factorisation is noise. psi: the modes at the part's vertices. Collective.
void require_no_mechanism(const Problem& problem, const Solid& solid, const LocalDofs& local,
                          const Modes& modes, const BasisRows& psi);

// residual: of the modes, as chosen for this check. cancellation: see Modes. Throws Failure
// (kSolver).
void require_accurate(const PrecomputeFindings& findings, const Solid& solid, double residual,
                      double cancellation);

}  // namespace tremolo
