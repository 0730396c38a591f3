// Whether what was computed can be believed: a result that cannot is refused, with the reason.
#pragma once

#include "precompute/modes/modes.h"
#include "precompute/pipeline.h"

namespace tremolo {

// From here on materials differ so much that rounding in the stiff ones is felt in the soft ones.
inline constexpr double kContrast = 1e6;

// How many times stiffer the stiffest material is than the softest.
double stiffness_ratio(const Solid& solid);

// A hinge or a joint of one vertex lets a part move without strain: K is singular although enough
// vertices are fixed, and what a factorisation then returns is noise. psi: the modes at the part's
// vertices. All ranks together; throws Failure (kContent) on all of them.
void require_no_mechanism(const Problem& problem, const Solid& solid, const LocalDofs& local,
                          const Modes& modes, const BasisRows& psi);

// residual: of the modes, what they are judged by. cancellation: Modes'. Throws Failure (kSolver).
void require_accurate(const PrecomputeFindings& findings, const Solid& solid, double residual,
                      double cancellation);

}  // namespace tremolo
