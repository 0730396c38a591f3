// Stage "modes": the lowest eigenpairs of K psi = omega^2 M psi (thesis (4.2.2), which prints the
// pencil upside down), by shift-invert: block Lanczos on CHOLMOD's factor in one process, on
// MUMPS's on several ranks; with PETSc options or on a tiny mesh SLEPc's Krylov-Schur; or without a
// factor by SLEPc's LOBPCG.
#pragma once

#include <limits>
#include <memory>

#include "precompute/fem/matrices.h"
#include "precompute/solver/iterative_solver.h"
#include "precompute/solver/solver_choice.h"
#include "precompute/solver/sparse_cholesky.h"

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
  // The factor of K - shift * M: CHOLMOD's own, or else PETSc's, which the eigensolver owns.
  std::unique_ptr<SparseCholesky> cholesky;
  PetscEigenSolver keeper;
  PetscMatrix mumps;  // that factor when no eigensolver owns it
  Mat factor = nullptr;
  std::unique_ptr<IterativeSolver> iterative;  // in their place
};

// rigid: motions to leave out (may have no columns); then shift must be negative, because K is
// singular. Throws Failure: kContent when k exceeds what the mesh has, kSolver when SLEPc finds
// too few or the stiffness is singular.
Modes compute_modes(const Matrices& matrices, int count, const Columns& rigid, double shift,
                    unsigned threads = 1, LinearSolver solver = LinearSolver::kCholmod);

// The same without a factor. positions: of this rank's nodes, m.
Modes compute_modes_iteratively(const Matrices& matrices, int count, const Columns& rigid,
                                double shift, const std::vector<Eigen::Vector3d>& positions);

// Makes again what solved for the modes, bit for bit, if they come without: from the same matrices,
// rigid motions, solver, positions (of the iterative one) and number of BLAS's threads. Throws
// Failure like compute_modes.
void restore_solver(const Matrices& matrices, const Columns& rigid, LinearSolver solver,
                    const std::vector<Eigen::Vector3d>& positions, Modes& modes);

// Frees what solved for the modes, whose memory others need.
void release_solver(Modes& modes);

// Number of eigenvalues of (K, M) below `bound`, counted from the inertia of an LDL^T of
// K - bound*M (Sylvester) by MUMPS: no mode can hide from it.
int count_modes_below(const Matrices& matrices, double bound);

// The same in the memory of the modes' own factor, which is given up. -1: the factorisation, which
// does not pivot, was not stable, or its entries grew by more than most_growth.
int count_modes_below(const Matrices& matrices, double bound, SparseCholesky& factor,
                      unsigned threads,
                      double most_growth = std::numeric_limits<double>::infinity());

// What compute_modes found against that count, with the bound in the last gap, usually halfway to
// the first mode left out. Modes' own factor is used up and freed: there are never two.
struct InertiaCertificate {
  double bound = 0;  // (rad/s)^2
  int expected = 0;  // modes found below the bound, rigid ones included
  int counted = 0;   // by inertia
  std::string solver;
  bool complete() const { return expected == counted; }
};
InertiaCertificate certify(const Matrices& matrices, Modes& modes, int rigid_count,
                           unsigned threads = 1);

}  // namespace tremolo
