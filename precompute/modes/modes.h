// Stage "modes": the lowest eigenpairs of K psi = omega^2 M psi (thesis (4.2.2), which prints the
// pencil upside down), by shift-invert: block Lanczos on a factor of K - sigma M; with PETSc
// options or on a tiny mesh SLEPc's Krylov-Schur; or without a factor by SLEPc's LOBPCG.
#pragma once

#include "precompute/solver/shifted_solver.h"

namespace tremolo {

struct Modes {
  Eigen::VectorXd squared_frequencies;  // k, (rad/s)^2, ascending
  Columns vectors;                      // local dofs x k, M-orthonormal, kg^-1/2
  Eigen::VectorXd residuals;            // |K psi - w2 M psi| / |w2 M psi|, 2-norms
  std::vector<double> left_out;         // squared frequencies found beyond, ascending
  double scaled_residual = 0;           // the largest, rows divided by sqrt(K_ii)
  double next_squared_frequency = 0;    // the first one left out; 0 if there is none
  double cancellation = 1;              // omega_1^2 / sum K_ii psi_i^2: what is left of the terms
  double shift = 0;                     // sigma of the factorisation, <= 0
  int solves = 0;                       // on the factor, columns; 0: SLEPc's
  std::string solver;                   // who found them
  std::string factorisation;            // the package that factorised
};

// The `count` lowest. The solver is prepared at `shift`, which must be negative where the pencil
// has rigid motions to leave out, and stays so. Throws Failure: kContent when count exceeds what
// the mesh has, kSolver when too few are found or the stiffness is singular.
Modes compute_modes(const Pencil& pencil, ShiftedSolver& solver, double shift, int count);

// The same and as many more as it takes, 32 at most, for no run of equal frequencies
// (mode_clusters.h) to begin within the `count` and go on beyond what was computed.
Modes compute_modes_and_equals(const Pencil& pencil, ShiftedSolver& solver, double shift,
                               int count);

// How many eigenpairs there are, rigid motions left out.
int available_modes(const Pencil& pencil);

}  // namespace tremolo
