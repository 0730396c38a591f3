// One interface to a factor of K - sigma M, with three implementations: CHOLMOD's factor in one
// process (cholmod_solver.cpp), MUMPS's over several ranks (mumps_solver.cpp), and multigrid, which
// needs no factor (multigrid_solver.cpp).
#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "precompute/dense/blas.h"
#include "precompute/fem/matrices.h"
#include "precompute/solver/solver_choice.h"

namespace tremolo {

// K x = lambda M x over this rank's rows, and what its solvers want to know. Borrows the matrices
// and the motions.
struct Pencil {
  const Matrices& matrices;
  const Columns& rigid;  // M-orthonormal motions to stay away from, local rows; may have no columns
  LinearSolver package = LinearSolver::kCholmod;
  unsigned threads = 1;
  std::vector<Eigen::Vector3d> positions = {};  // of this rank's nodes, m; for multigrid alone

  Mat mass() const { return matrices.mass.get(); }
  Mat stiffness() const { return matrices.stiffness.get(); }
  Eigen::Index rows() const;      // of this rank
  Eigen::Index all_rows() const;  // of all ranks
};

// negative: eigenvalues of (K, M) below a bound. package: who counted.
struct InertiaCount {
  int negative = 0;
  std::string package;
};

class ShiftedSolver {
 public:
  virtual ~ShiftedSolver() = default;

  // Makes what solves with K - sigma M, unless it is there; the same matrices, sigma and number of
  // BLAS threads give the same bits. sigma <= 0 in (rad/s)^2, negative where K is singular. Throws
  // Failure: kSolver when the matrix is not positive definite, kSystem when memory runs out.
  void prepare(double sigma);

  // Gives the memory back.
  void release();

  bool ready() const { return ready_; }
  double sigma() const { return sigma_; }  // of the last prepare()

  // X = (K - sigma M)^-1 B, this rank's rows x columns; b and x may be the same. To be called
  // between prepare() and release(), on all ranks together; where `threads_may_share`, threads may
  // call it side by side, and a column's result does not depend on its neighbours.
  virtual void solve(const ColumnsRef& b, ColumnsOut x) const = 0;
  virtual bool threads_may_share() const { return false; }

  // True where sigma only preconditions: solve() gives K^-1 B then, of B without rigid share.
  virtual bool solves_unshifted() const { return false; }

  // Counts the eigenvalues of (K, M) below `bound`, (rad/s)^2, by the inertia of an L D L^T of
  // K - bound M (Sylvester): no mode can hide from it. Releases the factor: there are never two;
  // one at `sigma` may be of use and is made if it is not there. A count whose factor grew by more
  // than `most_growth` times rounding is not taken. Throws Failure (kSolver) when none can be had.
  virtual InertiaCount count_negative(double sigma, double bound, double most_growth) = 0;

  // The package that solves, for reports.
  virtual std::string package() const = 0;

  // Floating-point operations of the last factorisation, and the factor's entries, 8 bytes each; 0
  // where they are not known.
  virtual double flops() const { return 0; }
  virtual double entries() const { return 0; }

 protected:
  virtual void factorise(double sigma) = 0;
  virtual void free_factor() = 0;

 private:
  double sigma_ = 0;
  bool ready_ = false;
};

inline constexpr double kAnyGrowth = std::numeric_limits<double>::infinity();

// The solver of the pencil's package; MUMPS for CHOLMOD on several ranks. Borrows the pencil.
std::unique_ptr<ShiftedSolver> make_shifted_solver(const Pencil& pencil);

// Each package's own.
std::unique_ptr<ShiftedSolver> make_cholmod_solver(const Pencil& pencil);
std::unique_ptr<ShiftedSolver> make_mumps_solver(const Pencil& pencil);
std::unique_ptr<ShiftedSolver> make_multigrid_solver(const Pencil& pencil);

// That count by MUMPS, which needs no factor of another matrix.
InertiaCount count_negative_by_mumps(const Matrices& matrices, double bound);

}  // namespace tremolo
