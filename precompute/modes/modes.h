// Stage "modes": the lowest eigenpairs of K psi = omega^2 M psi (thesis (4.2.2), which prints the
// pencil inverted). Methods: block Lanczos on a factor of K - sigma M; SLEPc's Krylov-Schur if
// PETSc options are given or the mesh is tiny; SLEPc's LOBPCG without a factor.
#pragma once

#include "precompute/solver/shifted_solver.h"

namespace tremolo {

struct Modes {
  Eigen::VectorXd squared_frequencies;  // k, (rad/s)^2, ascending
  Columns vectors;                      // local dofs x k, M-orthonormal, kg^-1/2
  Eigen::VectorXd residuals;            // |K psi - w2 M psi| / |w2 M psi|, 2-norms
  std::vector<double> left_out;         // squared frequencies found beyond the cut, ascending
  double scaled_residual = 0;           // the largest residual, rows divided by sqrt(K_ii)
  double next_squared_frequency = 0;    // (rad/s)^2; the first one left out; 0 if there is none
  double cancellation = 1;              // omega_1^2 / sum K_ii psi_i^2 of the first mode
  double shift = 0;                     // sigma of the factorisation, (rad/s)^2, <= 0
  int solves = 0;             // right-hand sides solved with the factor; 0 if SLEPc solved
  std::string solver;         // name of the eigensolver
  std::string factorisation;  // package of the factor
};

// Computes the `count` lowest modes. The solver is prepared at `shift` and stays so; the shift must
// be negative if the pencil has rigid motions. Throws Failure: kContent if count exceeds the number
// of free dofs, kSolver if too few modes are found or the stiffness is singular.
Modes compute_modes(const Pencil& pencil, ShiftedSolver& solver, double shift, int count);

// As compute_modes, with up to 32 more modes, as many as are needed so that no cluster of equal
// frequencies (mode_clusters.h) begins within the `count` and continues beyond what was computed.
Modes compute_modes_and_equals(const Pencil& pencil, ShiftedSolver& solver, double shift,
                               int count);

// Returns the number of eigenpairs without rigid motions.
int available_modes(const Pencil& pencil);

}  // namespace tremolo
