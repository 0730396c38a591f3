#include "precompute/derivatives.h"

#include <cmath>

#include "common/packed_index.h"
#include "common/parallel.h"
#include "precompute/failure.h"

namespace tremolo {
namespace {

void require(PetscErrorCode code) {
  check_petsc(code, "solve for the modal derivatives");
}

Columns right_hand_sides(const Solid& solid, const LocalDofs& local, const Eigen::MatrixXd& psi,
                         unsigned threads) {
  const auto modes = static_cast<std::size_t>(psi.cols());
  Columns loads = Columns::Zero(local.dofs(), static_cast<Eigen::Index>(pair_count(modes)));
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t j = 0; j < modes; ++j)
    for (std::size_t i = 0; i <= j; ++i) pairs.emplace_back(i, j);
  parallel_for(pairs.size(), threads, [&](std::size_t p) {
    add_second_derivative(solid, local.elements, psi.col(pairs[p].first), psi.col(pairs[p].second),
                          local.row_of_vertex, loads.col(static_cast<Eigen::Index>(p)).data());
  });
  loads *= -1.0;
  return loads;
}

Columns solve(Mat factor, const Columns& loads) {
  Columns solution(loads.rows(), loads.cols());
  const PetscMatrix b = as_dense(loads);
  const PetscMatrix x = as_dense(solution);
  require(MatMatSolve(factor, b.get(), x.get()));
  return solution;
}

// Takes the part out of the loads that would set the body moving as a whole.
void balance(const Matrices& matrices, const Columns& rigid, Columns& loads) {
  if (rigid.cols() > 0)
    loads -= multiply(matrices.mass.get(), rigid) * inner_products(rigid, loads);
}

// K X = B on the M-complement of the rigid modes, with the factor of K + sM: X <- (K + sM)^-1
// (B + sM X) contracts every mode by s / (omega^2 + s).
Columns solve_on_complement(const Modes& modes, const Matrices& matrices, const Columns& rigid,
                            const Columns& loads) {
  constexpr int kMaxRounds = 200;
  constexpr double kTolerance = 1e-13;  // of the change, relative: rounding of the solves
  constexpr double kStalled = 1e-6;     // the residual is checked afterwards
  const Columns mass_rigid = multiply(matrices.mass.get(), rigid);
  double last = 1.0;
  Columns solution = Columns::Zero(loads.rows(), loads.cols());
  for (int round = 0; round < kMaxRounds; ++round) {
    Columns next =
        solve(modes.factor, loads - modes.shift * multiply(matrices.mass.get(), solution));
    next -= rigid * inner_products(mass_rigid, next);
    Eigen::MatrixXd change(2, 1);
    change << (next - solution).squaredNorm(), next.squaredNorm();
    sum_over_ranks(change);
    solution = std::move(next);
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

double largest_residual(const Matrices& matrices, const Columns& solution, const Columns& loads) {
  const Columns residual = multiply(matrices.stiffness.get(), solution) - loads;
  Eigen::MatrixXd squares(2, loads.cols());
  squares.row(0) = residual.colwise().squaredNorm();
  squares.row(1) = loads.colwise().squaredNorm();
  sum_over_ranks(squares);
  // A pair of modes of parts that do not touch has no load: against the largest one.
  const Eigen::ArrayXd scale =
      squares.row(1).transpose().array().max(1e-20 * squares.row(1).maxCoeff());
  return std::sqrt((squares.row(0).transpose().array() / scale).maxCoeff());
}

}  // namespace

ModalDerivatives modal_derivatives(const Solid& solid, const LocalDofs& local,
                                   const Matrices& matrices, const Modes& modes,
                                   const Eigen::MatrixXd& psi, const Columns& rigid,
                                   unsigned threads) {
  Columns loads = right_hand_sides(solid, local, psi, threads);
  balance(matrices, rigid, loads);
  ModalDerivatives derivatives;
  derivatives.vectors = rigid.cols() == 0 ? solve(modes.factor, loads)
                                          : solve_on_complement(modes, matrices, rigid, loads);
  derivatives.residual = largest_residual(matrices, derivatives.vectors, loads);
  return derivatives;
}

}  // namespace tremolo
