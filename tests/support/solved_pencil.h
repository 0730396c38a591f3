// A pencil with its solver, and modes of it, for tests of single stages.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "precompute/modes/modes.h"
#include "precompute/solver/shifted_solver.h"

namespace tremolo::testing {

// Owns the motions that the pencil borrows; stays where it is.
class SolvedPencil {
 public:
  SolvedPencil(const Matrices& matrices, Columns motions, double sigma = 0.0, unsigned threads = 1,
               LinearSolver package = LinearSolver::kCholmod,
               std::vector<Eigen::Vector3d> positions = {})
      : rigid(std::move(motions)),
        shift(sigma),
        pencil{matrices, rigid, package, threads, std::move(positions)},
        solver(make_shifted_solver(pencil)) {}
  // The pencil of a fixed body.
  explicit SolvedPencil(const Matrices& matrices, unsigned threads = 1)
      : SolvedPencil(matrices, no_motions(matrices), 0.0, threads) {}
  SolvedPencil(const SolvedPencil&) = delete;
  SolvedPencil& operator=(const SolvedPencil&) = delete;

  Modes modes(int count) { return compute_modes(pencil, *solver, shift, count); }

  Columns rigid;
  double shift;
  Pencil pencil;
  std::unique_ptr<ShiftedSolver> solver;

 private:
  static Columns no_motions(const Matrices& matrices) {
    PetscInt rows = 0;
    check_petsc(MatGetLocalSize(matrices.mass.get(), &rows, nullptr), "read a size");
    return Columns(rows, 0);
  }
};

}  // namespace tremolo::testing
