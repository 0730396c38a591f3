#include "precompute/reduction/derivatives.h"

#include <cmath>
#include <functional>

#include "common/packed_index.h"
#include "precompute/dense/parallel_columns.h"
#include "precompute/fem/element_group.h"
#include "precompute/system/blas_threads.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

constexpr Eigen::Index kBlock = 28;  // 210 columns are eight blocks: the threads end together

void require(PetscErrorCode code) {
  check_petsc(code, "solve for the modal derivatives");
}

// What a block of columns needs of the mesh's matrices: in one process every thread has its own,
// on several ranks they are PETSc's and all ranks call them together.
struct Operators {
  std::function<Columns(const Columns&)> mass;
  std::function<Columns(const Columns&)> stiffness;
  std::function<Columns(const Columns&)> solve;          // with the factor of K - shift M
  std::function<void(Eigen::MatrixXd&)> sum_over_ranks;  // in place

  Eigen::MatrixXd inner_products(const Columns& x, const Columns& y) const {
    Eigen::MatrixXd products = transposed_product(x, y);
    sum_over_ranks(products);
    return products;
  }
};

Operators thread_operators(const Matrices& matrices, const SparseCholesky& factor) {
  const auto product = [](const SparseRows& matrix) {
    return [matrix](const Columns& x) {
      Columns y(x.rows(), x.cols());
      multiply(matrix, x, y);
      return y;
    };
  };
  const auto solve = [&factor](const Columns& b) {
    SparseCholesky::Workspace workspace;
    Columns x(b.rows(), b.cols());
    factor.solve(b, x, workspace);
    return x;
  };
  return {product(sparse_rows(matrices.mass.get())), product(sparse_rows(matrices.stiffness.get())),
          solve, [](Eigen::MatrixXd&) {}};
}

Operators petsc_operators(const Matrices& matrices, Mat factor) {
  const auto product = [](Mat matrix) {
    return [matrix](const Columns& x) { return multiply(matrix, x); };
  };
  const auto solve = [factor](const Columns& b) {
    Columns x(b.rows(), b.cols());
    const PetscMatrix from = as_dense(b);
    const PetscMatrix to = as_dense(x);
    require(MatMatSolve(factor, from.get(), to.get()));
    return x;
  };
  return {product(matrices.mass.get()), product(matrices.stiffness.get()), solve,
          [](Eigen::MatrixXd& matrix) { sum_over_ranks(matrix); }};
}

Operators iterative_operators(const Matrices& matrices, IterativeSolver& solver) {
  Operators on = petsc_operators(matrices, nullptr);
  on.solve = [&solver](const Columns& b) { return solve(solver, b); };
  return on;
}

// Without a factor the shift is the preconditioner's alone: K X = B itself is solved.
Columns iterate_on_complement(const Operators& on, const Columns& rigid, const Columns& mass_rigid,
                              const Columns& loads) {
  Columns solution = on.solve(loads);
  if (rigid.cols() > 0)
    add_product(-1.0, rigid, on.inner_products(mass_rigid, solution), 1.0, solution);
  return solution;
}

// K X = B on the M-complement of the rigid modes, with the factor of K + sM: X <- (K + sM)^-1
// (B + sM X) contracts every mode by s / (omega^2 + s).
Columns solve_on_complement(const Operators& on, double shift, const Columns& rigid,
                            const Columns& mass_rigid, const Columns& loads) {
  constexpr int kMaxRounds = 200;
  constexpr double kTolerance = 1e-13;  // of the change, relative: rounding of the solves
  constexpr double kStalled = 1e-6;     // the residual is checked afterwards
  double last = 1.0;
  Columns solution = Columns::Zero(loads.rows(), loads.cols());
  for (int round = 0; round < kMaxRounds; ++round) {
    Columns next = on.solve(loads - shift * on.mass(solution));
    add_product(-1.0, rigid, on.inner_products(mass_rigid, next), 1.0, next);
    Eigen::MatrixXd change(2, 1);
    change << (next - solution).squaredNorm(), next.squaredNorm();
    on.sum_over_ranks(change);
    solution = std::move(next);
    if (change(1) == 0.0) return solution;  // of parts that do not touch
    const double relative = std::sqrt(change(0) / change(1));
    if (relative <= kTolerance) return solution;
    // A thin body's solves carry more rounding than the tolerance: done when it shrinks no more.
    if (relative <= kStalled && relative > 0.5 * last) return solution;
    last = relative;
  }
  throw Failure({ErrorKind::kSolver,
                 "the modal derivatives of the free body did not converge: its lowest elastic mode "
                 "is too close to rigid motion"});
}

// squares: 2 x columns, |residual|^2 and |load|^2.
double largest_residual(Eigen::MatrixXd squares) {
  sum_over_ranks(squares);
  // A pair of modes of parts that do not touch has no load: against the largest one.
  const Eigen::ArrayXd scale =
      squares.row(1).transpose().array().max(1e-20 * squares.row(1).maxCoeff());
  return std::sqrt((squares.row(0).transpose().array() / scale).maxCoeff());
}

}  // namespace

ModalDerivatives modal_derivatives(const Solid& solid, const LocalDofs& local,
                                   const Matrices& matrices, const Modes& modes,
                                   const BasisRows& psi, const Columns& rigid, unsigned threads) {
  std::vector<ColumnPair> pairs;
  for (int j = 0; j < static_cast<int>(psi.cols()); ++j)
    for (int i = 0; i <= j; ++i) pairs.push_back({i, j});
  const auto count = static_cast<Eigen::Index>(pairs.size());
  const Columns mass_rigid =
      rigid.cols() > 0 ? multiply(matrices.mass.get(), rigid) : Columns(local.dofs(), 0);

  ModalDerivatives result;
  result.modes = modes.vectors.cols();
  result.columns.resize(local.dofs(), result.modes + count);
  result.columns.leftCols(result.modes) = modes.vectors;
  Eigen::MatrixXd squares(2, count);
  const auto compute_block = [&](const Operators& on, Eigen::Index first, Eigen::Index width) {
    Columns loads = Columns::Zero(local.dofs(), width);
    subtract_second_derivatives(
        solid, local.elements, psi, {pairs.begin() + first, pairs.begin() + first + width},
        local.row_of_vertex, loads.data(), static_cast<std::size_t>(loads.rows()));
    // The part that would set the body moving as a whole is taken out.
    if (rigid.cols() > 0)
      add_product(-1.0, mass_rigid, on.inner_products(rigid, loads), 1.0, loads);
    const Columns solution =
        modes.iterative != nullptr ? iterate_on_complement(on, rigid, mass_rigid, loads)
        : rigid.cols() == 0        ? on.solve(loads)
                                   : solve_on_complement(on, modes.shift, rigid, mass_rigid, loads);
    squares.row(1).segment(first, width) = loads.colwise().squaredNorm();
    squares.row(0).segment(first, width) = (on.stiffness(solution) - loads).colwise().squaredNorm();
    result.columns.middleCols(result.modes + first, width) = solution;
  };
  if (modes.cholesky != nullptr) {
    const Operators on = thread_operators(matrices, *modes.cholesky);
    const BlasThreads single(1);
    parallel_columns(count, kBlock, threads, [&](Eigen::Index first, Eigen::Index width) {
      compute_block(on, first, width);
    });
  } else {
    const Operators on = modes.iterative != nullptr
                             ? iterative_operators(matrices, *modes.iterative)
                             : petsc_operators(matrices, modes.factor);
    for (Eigen::Index first = 0; first < count; first += kBlock)
      compute_block(on, first, std::min(kBlock, count - first));
  }
  result.residual = largest_residual(squares);
  return result;
}

}  // namespace tremolo
