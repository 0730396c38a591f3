// Modes and solves without a factor, for meshes whose factor would not fit: PETSc's smoothed
// aggregation multigrid (GAMG, told the rigid motions) as the preconditioner of conjugate gradients
// and of SLEPc's block eigensolver LOBPCG. Memory grows with the mesh and no faster.
#pragma once

#include <string>
#include <vector>

#include "precompute/fem/matrices.h"

namespace tremolo {

using PetscLinearSolver = PetscHandle<KSP, KSPDestroy>;

// x <- K^-1 b by conjugate gradients, to kSolveTolerance of |b| in the preconditioned norm. A free
// body's K is singular: loads must be self-balancing, the preconditioner is that of K - shift M.
struct IterativeSolver {
  PetscMatrix shifted;  // K - shift M; empty when shift = 0
  PetscLinearSolver conjugate_gradients;
};
inline constexpr double kSolveTolerance = 1e-11;

// positions: of this rank's nodes, m. rigid: M-orthonormal, may have no columns. Borrows matrices.
IterativeSolver make_iterative_solver(const Matrices& matrices,
                                      const std::vector<Eigen::Vector3d>& positions,
                                      const Columns& rigid, double shift);

// Column by column; all ranks together. Throws Failure (kSolver) when it does not converge.
Columns solve(IterativeSolver& solver, const Columns& loads);

// The lowest eigenpairs of (K, M), M-orthogonal to `rigid`; ascending. residual: of which it is
// satisfied, |K x - w2 M x| / |w2 M x|. Throws Failure (kSolver) when it does not converge.
struct IterativeModes {
  Eigen::VectorXd squared_frequencies;
  Columns vectors;
  int iterations = 0;
  std::string solver;  // who found them
};
IterativeModes iterative_modes(const Matrices& matrices,
                               const std::vector<Eigen::Vector3d>& positions, int wanted,
                               const Columns& rigid, double shift, double residual);

}  // namespace tremolo
