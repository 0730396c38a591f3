// One interface to a factor of K - sigma M with three implementations: CHOLMOD's factor in one
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

// The pencil K x = lambda M x on this rank's rows with the data its solvers need. It holds
// references to the matrices and the rigid motions.
struct Pencil {
  const Matrices& matrices;
  const Columns& rigid;  // M-orthonormal motions to be deflated, local rows; may have no columns
  LinearSolver package = LinearSolver::kCholmod;
  unsigned threads = 1;
  std::vector<Eigen::Vector3d> positions = {};  // of this rank's nodes, m; used by multigrid only

  Mat mass() const { return matrices.mass.get(); }
  Mat stiffness() const { return matrices.stiffness.get(); }
  Eigen::Index rows() const;      // of this rank
  Eigen::Index all_rows() const;  // of all ranks
};

// negative: number of eigenvalues of (K, M) below a bound. package: name of the package that
// counted.
struct InertiaCount {
  int negative = 0;
  std::string package;
};

class ShiftedSolver {
 public:
  virtual ~ShiftedSolver() = default;

  // Factorises K - sigma M unless that factor exists. The same matrices, sigma and number of BLAS
  // threads give the same bits. sigma: (rad/s)^2, <= 0, negative if K is singular. Throws Failure:
  // kSolver if the matrix is not positive definite, kSystem if memory runs out.
  void prepare(double sigma);

  // Frees the factor.
  void release();

  bool ready() const { return ready_; }
  double sigma() const { return sigma_; }  // (rad/s)^2, of the last prepare()

  // Computes X = (K - sigma M)^-1 B, this rank's rows x columns; b and x may be the same. Requires
  // prepare() without a release() since. Collective, unless threads_may_share(): then threads may
  // call it concurrently, and the result of a column does not depend on the others.
  virtual void solve(const ColumnsRef& b, ColumnsOut x) const = 0;
  virtual bool threads_may_share() const { return false; }

  // Returns true if sigma affects the preconditioner only: solve() then computes K^-1 B, and B must
  // have no rigid component.
  virtual bool solves_unshifted() const { return false; }

  // Counts the eigenvalues of (K, M) below `bound`, (rad/s)^2, by the inertia of an L D L^T factor
  // of K - bound M (Sylvester), which no mode escapes. Releases the factor, since there is never
  // memory for two; a factor at `sigma` may be computed first. A count with a growth of more than
  // `most_growth` times rounding is rejected. Throws Failure (kSolver) if no count is possible.
  virtual InertiaCount count_negative(double sigma, double bound, double most_growth) = 0;

  // Returns the name of the package that solves, for reports.
  virtual std::string package() const = 0;

  // Return the floating-point operations of the last factorisation and the number of the factor's
  // entries, 8 bytes each; 0 if unknown.
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

// Creates the solver for the pencil's package; on several ranks MUMPS replaces CHOLMOD. It holds a
// reference to the pencil.
std::unique_ptr<ShiftedSolver> make_shifted_solver(const Pencil& pencil);

// Create the solver of one package.
std::unique_ptr<ShiftedSolver> make_cholmod_solver(const Pencil& pencil);
std::unique_ptr<ShiftedSolver> make_mumps_solver(const Pencil& pencil);
std::unique_ptr<ShiftedSolver> make_multigrid_solver(const Pencil& pencil);

// Counts the eigenvalues below `bound` by MUMPS, without using another factor.
InertiaCount count_negative_by_mumps(const Matrices& matrices, double bound);

}  // namespace tremolo
