#include "precompute/solver/shifted_solver.h"

namespace tremolo {

Eigen::Index Pencil::rows() const {
  PetscInt rows = 0;
  check_petsc(MatGetLocalSize(mass(), &rows, nullptr), "read the size of the matrices");
  return rows;
}

Eigen::Index Pencil::all_rows() const {
  PetscInt rows = 0;
  check_petsc(MatGetSize(mass(), &rows, nullptr), "read the size of the matrices");
  return rows;
}

void ShiftedSolver::prepare(double sigma) {
  if (ready_ && sigma == sigma_) return;
  release();
  factorise(sigma);
  sigma_ = sigma;
  ready_ = true;
}

void ShiftedSolver::release() {
  ready_ = false;
  free_factor();
}

std::unique_ptr<ShiftedSolver> make_shifted_solver(const Pencil& pencil) {
  if (pencil.package == LinearSolver::kIterative) return make_multigrid_solver(pencil);
  if (pencil.package == LinearSolver::kCholmod && mpi_ranks() == 1)
    return make_cholmod_solver(pencil);
  return make_mumps_solver(pencil);
}

}  // namespace tremolo
