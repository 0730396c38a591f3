// The stages of a precompute from the matrices on: computation, checkpoint data and log lines of
// each.
#pragma once

#include <memory>
#include <optional>

#include "precompute/checkpoint/checkpoint_stages.h"
#include "precompute/pipeline.h"
#include "precompute/stage.h"

namespace tremolo {

// Data shared by the stages. It holds references to all but the counts.
struct Run {
  const ModelRequest& request;
  const PrecomputeResult& result;  // mesh and dofs; later the rows of the basis
  const SolverChoice& choice;
  Checkpoint& checkpoint;
  const StageLog& log;  // for messages during a stage
  ModeCounts counts;    // a default may be extended, so that a cluster is not divided
  int rigid_count = 0;  // number of a free body's rigid motions
};

// This rank's part of K x = lambda M x and its origin.
struct System {
  std::unique_ptr<const TetMesh> part;  // with several ranks; else null
  Solid solid;                          // of that part, or of the whole mesh
  Matrices matrices;
  Columns rigid;  // rigid motions of a free body, local rows; else no columns
  Marker marker;
};
Stage<System> matrices_stage(const Run& run);
Pencil make_pencil(const Run& run, const System& system);

// The system, its pencil and the solver used by the modes and later stages.
struct Solved {
  const System& system;
  const Pencil& pencil;
  ShiftedSolver& solver;
};

// Throws Failure (kContent) for a mechanism.
Stage<WholeModes> modes_stage(const Run& run, const Solved& on);

// psi: the modes at the vertices of this rank's part.
Stage<ModalDerivatives> derivatives_stage(const Run& run, const Solved& on, const Modes& modes,
                                          const BasisRows& psi);

// The places of the result.
Stage<RestResponse> response_stage(const Run& run, const Solved& on, const Modes& modes);

// Releases the solver's factor. Throws Failure (kSolver) if modes were missed.
Stage<InertiaCertificate> certificate_stage(const Run& run, const Solved& on, const Modes& modes);

// Input of the basis: a finished basis from the checkpoint, directions in the order of their
// singular values, or the columns to compute these from. The stages consume it.
struct BasisSource {
  std::optional<FinishedBasis> finished;
  std::optional<PrincipalColumns> directions;
  ModalDerivatives derivatives;
};

// Result of --target-error, which chooses r.
struct TargetChoice {
  PrincipalColumns directions;
  TargetFindings findings;
};
Stage<TargetChoice> target_stage(const Run& run, const System& system, const Modes& modes,
                                 const BasisRows& psi, BasisSource& source, TargetSearch& target);

Stage<FinishedBasis> basis_stage(const Run& run, const System& system, const Modes& modes,
                                 const BasisRows& psi, BasisSource& source);

// Uses the rows of the result.
Stage<InertiaIntegrals> inertia_stage(const Run& run, const System& system);
Stage<FinishedCoefficients> coefficients_stage(const Run& run, const System& system);

}  // namespace tremolo
