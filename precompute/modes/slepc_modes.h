// Modes by SLEPc: Krylov-Schur with the shifted solver, for meshes too small for blocks and for
// those who give it options; LOBPCG, preconditioned by multigrid, where there is no factor.
#pragma once

#include <string>

#include "precompute/solver/shifted_solver.h"

namespace tremolo {

// vectors: this rank's rows, M-orthogonal to the pencil's rigid motions. solver: who found them.
struct SlepcModes {
  Eigen::VectorXd squared_frequencies;  // ascending, (rad/s)^2
  Columns vectors;
  std::string solver;
  std::string factorisation;  // the package the user's options chose; empty: the solver's own
};

// Whether the user told the eigensolver or its inner solver something.
bool slepc_options_given();

// The `wanted` lowest. The solver is prepared at sigma afterwards; while options that begin with
// -st_ ask for a factor of PETSc's own, it is released. Throws Failure (kSolver) when SLEPc finds
// too few.
SlepcModes krylov_schur_modes(const Pencil& pencil, ShiftedSolver& solver, double sigma,
                              int wanted);

// The same without a factor, to |K x - w2 M x| / |w2 M x| of `residual`.
SlepcModes lobpcg_modes(const Pencil& pencil, double sigma, int wanted, double residual);

}  // namespace tremolo
