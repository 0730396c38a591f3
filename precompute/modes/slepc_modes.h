// Modes by SLEPc: Krylov-Schur with the shifted solver, for meshes too small for blocks and if
// SLEPc options are given; LOBPCG with multigrid as preconditioner if there is no factor.
#pragma once

#include <string>

#include "precompute/solver/shifted_solver.h"

namespace tremolo {

// vectors: this rank's rows, M-orthogonal to the rigid motions. solver: name of the eigensolver.
struct SlepcModes {
  Eigen::VectorXd squared_frequencies;  // ascending, (rad/s)^2
  Columns vectors;
  std::string solver;
  std::string factorisation;  // package chosen by PETSc options; empty: the shifted solver's own
};

// Returns whether the user has set options of the eigensolver or of its inner solver.
bool slepc_options_given();

// Computes the `wanted` lowest modes. The solver is prepared at sigma afterwards; it is released in
// the meantime if options that begin with -st_ ask for a factor of PETSc's own. Throws Failure
// (kSolver) if SLEPc finds too few.
SlepcModes krylov_schur_modes(const Pencil& pencil, ShiftedSolver& solver, double sigma,
                              int wanted);

// Does the same without a factor, until |K x - w2 M x| / |w2 M x| is at most `residual`.
SlepcModes lobpcg_modes(const Pencil& pencil, double sigma, int wanted, double residual);

}  // namespace tremolo
