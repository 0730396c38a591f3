// The stages of a precompute from the matrices on: what each computes, what is kept of it, and what
// is said.
#pragma once

#include <memory>
#include <optional>

#include "precompute/checkpoint/checkpoint_stages.h"
#include "precompute/pipeline.h"
#include "precompute/stage.h"

namespace tremolo {

// What the stages share. Borrows all but the counts.
struct Run {
  const ModelRequest& request;
  const PrecomputeResult& result;  // mesh and dofs; later the rows of the basis
  const SolverChoice& choice;
  Checkpoint& checkpoint;
  const StageLog& log;  // for what is told while a stage is under way
  ModeCounts counts;    // a default may become more, so as not to cut between equals
  int rigid_count = 0;  // of a free body's motions
};

// This rank's part of K x = lambda M x, and of where it came from.
struct System {
  std::unique_ptr<const TetMesh> part;  // of several ranks
  Solid solid;                          // on that part, or on the whole mesh
  Matrices matrices;
  Columns rigid;  // motions of a free body, local rows; no columns if the body is held
  Marker marker;
};
Stage<System> matrices_stage(const Run& run);
Pencil make_pencil(const Run& run, const System& system);

// What the modes solve with, and them.
struct Solved {
  const System& system;
  const Pencil& pencil;
  ShiftedSolver& solver;
};

// Fails with kContent for a mechanism.
Stage<WholeModes> modes_stage(const Run& run, const Solved& on);

// psi: the modes at the vertices of this rank's part.
Stage<ModalDerivatives> derivatives_stage(const Run& run, const Solved& on, const Modes& modes,
                                          const BasisRows& psi);

// Takes the solver's memory. Fails with kSolver when modes were missed.
Stage<InertiaCertificate> certificate_stage(const Run& run, const Solved& on, const Modes& modes);

// What the basis is made of: a basis that is there, directions in the order of their singular
// values, or the columns that these are made of. The stages use it up.
struct BasisSource {
  std::optional<FinishedBasis> finished;
  std::optional<PrincipalColumns> directions;
  ModalDerivatives derivatives;
};

// --target-error chooses r.
struct TargetChoice {
  PrincipalColumns directions;
  TargetFindings findings;
};
Stage<TargetChoice> target_stage(const Run& run, const System& system, const Modes& modes,
                                 const BasisRows& psi, BasisSource& source, TargetSearch& target);

Stage<FinishedBasis> basis_stage(const Run& run, const System& system, const Modes& modes,
                                 const BasisRows& psi, BasisSource& source);

// Of the result's rows.
Stage<FinishedCoefficients> coefficients_stage(const Run& run, const System& system);

}  // namespace tremolo
