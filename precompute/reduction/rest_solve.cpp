#include "precompute/reduction/rest_solve.h"

#include <algorithm>
#include <cmath>

#include "precompute/dense/parallel_columns.h"
#include "precompute/dense/sparse_rows.h"
#include "precompute/system/blas_threads.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

// The pencil's operators on a block of columns. If threads may share the solver, each handles its
// own block and no operator calls PETSc; else the operators are collective.
struct Operators {
  SparseProduct mass;
  SparseProduct stiffness;
  const ShiftedSolver& solver;

  Operators(const Pencil& pencil, const ShiftedSolver& shifted)
      : mass(pencil.mass()), stiffness(pencil.stiffness()), solver(shifted) {}

  Columns solve(const Columns& loads) const {
    Columns solution(loads.rows(), loads.cols());
    solver.solve(loads, solution);
    return solution;
  }
  Eigen::MatrixXd inner_products(const Columns& x, const Columns& y) const {
    Eigen::MatrixXd products = transposed_product(x, y);
    sum(products);
    return products;
  }
  void sum(Eigen::MatrixXd& matrix) const {
    if (!solver.threads_may_share()) sum_over_ranks(matrix);
  }
};

// Removes the components along the rigid motions. mass_rigid: M times the motions.
void remove_rigid(const Operators& on, const Columns& rigid, const Columns& mass_rigid,
                  Columns& columns) {
  if (rigid.cols() > 0)
    add_product(-1.0, rigid, on.inner_products(mass_rigid, columns), 1.0, columns);
}

// Solves K X = B on the M-complement of the rigid motions. With the factor of K + sM, s = -sigma,
// the iteration X <- (K + sM)^-1 (B + sM X) contracts every mode by s / (omega^2 + s).
Columns solve_on_complement(const Operators& on, const Columns& rigid, const Columns& mass_rigid,
                            const Columns& loads) {
  if (rigid.cols() == 0) return on.solve(loads);
  if (on.solver.solves_unshifted()) {
    Columns solution = on.solve(loads);
    remove_rigid(on, rigid, mass_rigid, solution);
    return solution;
  }
  constexpr int kMaxRounds = 200;
  constexpr double kTolerance = 1e-13;  // of the relative change: rounding of the solves
  constexpr double kStalled =
      1e-6;  // at a stalled change below this the residual decides (checked afterwards)
  double last = 1.0;
  Columns solution = Columns::Zero(loads.rows(), loads.cols());
  for (int round = 0; round < kMaxRounds; ++round) {
    Columns next = on.solve(loads - on.solver.sigma() * on.mass(solution));
    remove_rigid(on, rigid, mass_rigid, next);
    Eigen::MatrixXd change(2, 1);
    change << (next - solution).squaredNorm(), next.squaredNorm();
    on.sum(change);
    solution = std::move(next);
    if (change(1) == 0.0) return solution;  // modes of disconnected parts
    const double relative = std::sqrt(change(0) / change(1));
    if (relative <= kTolerance) return solution;
    // In a thin body rounding of the solves exceeds the tolerance: the iteration ends when the
    // change stagnates.
    if (relative <= kStalled && relative > 0.5 * last) return solution;
    last = relative;
  }
  throw Failure({ErrorKind::kSolver,
                 "the modal derivatives of the free body did not converge: its lowest elastic mode "
                 "is too close to rigid motion"});
}

// squares: 2 x columns, |residual|^2 and |right-hand side|^2.
double largest_residual(Eigen::MatrixXd squares) {
  sum_over_ranks(squares);
  // The right-hand side of two modes of disconnected parts is zero: the largest one is the scale.
  const Eigen::ArrayXd scale =
      squares.row(1).transpose().array().max(1e-20 * squares.row(1).maxCoeff());
  return std::sqrt((squares.row(0).transpose().array() / scale).maxCoeff());
}

}  // namespace

double solve_at_rest(const Pencil& pencil, const ShiftedSolver& solver, Eigen::Index block,
                     const FillLoads& fill, ColumnsOut solutions) {
  const Eigen::Index rows = solutions.rows(), count = solutions.cols();
  const Columns& rigid = pencil.rigid;
  const Columns mass_rigid = rigid.cols() > 0 ? multiply(pencil.mass(), rigid) : Columns(rows, 0);
  const Operators on(pencil, solver);
  Eigen::MatrixXd squares(2, count);
  const auto solve_block = [&](Eigen::Index first, Eigen::Index width) {
    Columns loads = Columns::Zero(rows, width);
    fill(first, loads);
    // Makes the right-hand side self-balancing, so that it does not move the body as a whole.
    if (rigid.cols() > 0)
      add_product(-1.0, mass_rigid, on.inner_products(rigid, loads), 1.0, loads);
    const Columns solution = solve_on_complement(on, rigid, mass_rigid, loads);
    squares.row(1).segment(first, width) = loads.colwise().squaredNorm();
    squares.row(0).segment(first, width) = (on.stiffness(solution) - loads).colwise().squaredNorm();
    solutions.middleCols(first, width) = solution;
  };
  if (solver.threads_may_share()) {
    const BlasThreads single(1);
    parallel_columns(count, block, pencil.threads, solve_block);
  } else {
    for (Eigen::Index first = 0; first < count; first += block)
      solve_block(first, std::min(block, count - first));
  }
  return largest_residual(squares);
}

}  // namespace tremolo
