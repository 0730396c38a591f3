// The stages of a precompute from the matrices on: computation, checkpoint data and log lines of
// each.
#pragma once

#include <memory>
#include <optional>

#include "precompute/checkpoint/checkpoint_stages.h"
#include "precompute/pipeline.h"
#include "precompute/stage.h"

namespace tremolo {

// This rank's part of K x = lambda M x and its origin.
struct System {
  std::unique_ptr<const TetMesh> part;  // with several ranks; else null
  Solid solid;                          // of that part, or of the whole mesh
  Matrices matrices;
  Columns rigid;  // rigid motions of a free body, local rows; else no columns
  Marker marker;
};
Stage<System> matrices_stage(const LoadedProblem& loaded, MassKind mass);
Pencil make_pencil(const LoadedProblem& loaded, const System& system, LinearSolver package,
                   unsigned threads);

// The system, its pencil and the solver used by the modes and later stages.
struct Solved {
  const LoadedProblem& loaded;
  const System& system;
  const Pencil& pencil;
  ShiftedSolver& solver;
};

// extend: `count` may grow, so that a cluster is not divided. Throws Failure (kContent) for a
// mechanism.
Stage<WholeModes> modes_stage(const Solved& on, int count, bool extend, Checkpoint& checkpoint);

// psi: the modes at the vertices of this rank's part. order: 2 or 3.
Stage<ModalDerivatives> derivatives_stage(const Solved& on, const Modes& modes,
                                          const BasisRows& psi, int order, Checkpoint& checkpoint);

// psi: the modes at the vertices of this rank's part.
Stage<ModeSensitivities> sensitivities_stage(const Solved& on, const Modes& modes,
                                             const BasisRows& psi, MassKind mass);

Stage<RestResponse> response_stage(const Solved& on, const Modes& modes);

// Releases the solver's factor. Throws Failure (kSolver) if modes were missed.
Stage<InertiaCertificate> certificate_stage(const Solved& on, const Modes& modes,
                                            Checkpoint& checkpoint);

// The body whose basis is made, and its modes.
struct BasisBody {
  const LoadedProblem& loaded;
  const System& system;
  const Modes& modes;
  const BasisRows& psi;
  unsigned threads;
  std::optional<int> keep_modes;  // of the request
};

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
Stage<TargetChoice> target_stage(const BasisBody& body, MassKind mass, BasisSource& source,
                                 TargetSearch& target, const StageLog& log);

// extend: `count` may grow, so that a cluster is not divided.
Stage<FinishedBasis> basis_stage(const BasisBody& body, int count, bool extend, BasisSource& source,
                                 Checkpoint& checkpoint, const StageLog& log);

// rows: of the basis.
Stage<InertiaIntegrals> inertia_stage(const LoadedProblem& loaded, const System& system,
                                      const BasisRows& rows, MassKind mass);
Stage<FinishedCoefficients> coefficients_stage(const LoadedProblem& loaded, const System& system,
                                               const BasisRows& rows, const Eigen::VectorXd& lambda,
                                               unsigned threads, Checkpoint& checkpoint);

}  // namespace tremolo
