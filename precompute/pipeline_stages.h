// The stages of a precompute from the modes on. Each finds its result in the checkpoint or makes
// and keeps it, takes what the report and the file want of it into the run's result, and says so.
#pragma once

#include "precompute/checkpoint/checkpoint_stages.h"
#include "precompute/dense/limits.h"
#include "precompute/pipeline.h"

namespace tremolo {

// What the stages share; all but the counts and the result is made when it is put together.
struct Run {
  const PrecomputeOptions& options;
  StageLog& log;
  PrecomputeResult& result;
  const MachineLimits& machine;
  const SolverChoice& choice;
  const Solid& solid;  // of this rank's part
  const Matrices& matrices;
  Checkpoint& checkpoint;
  ModeCounts counts;    // a default may become more, so as not to cut between equals
  int rigid_count = 0;  // of a free body's motions
  Columns rigid;        // these, local rows; no columns if the body is held
  Marker marker;
};

// psi: the modes at the vertices of this rank's part. Throws Failure (kContent) for a mechanism.
WholeModes make_modes(Run& run, BasisRows& psi);

// Just the modes when the run is linear.
ModalDerivatives make_derivatives(Run& run, Modes& modes, const BasisRows& psi);

// Takes the memory of the modes' factor. Throws Failure (kSolver) when modes were missed.
void certify_modes(Run& run, Modes& modes);

// Into the result's rows. finished: out of the checkpoint if it is `found` there. target: chooses
// r; false when it finds none, and there is no basis.
bool make_basis_rows(Run& run, const Modes& modes, const BasisRows& psi,
                     ModalDerivatives derivatives, TargetSearch* target, bool found,
                     FinishedBasis finished);

// Of the result's rows; nothing when the run is linear.
void make_coefficients(Run& run);

}  // namespace tremolo
