#include "precompute/modes/modes.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/text.h"
#include "precompute/dense/dense_decompositions.h"
#include "precompute/modes/block_lanczos.h"
#include "precompute/modes/mode_clusters.h"
#include "precompute/modes/slepc_modes.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

void require_modes(PetscErrorCode code) {
  check_petsc(code, "compute the modes");
}

Eigen::ArrayXd local_diagonal(Mat matrix, Eigen::Index rows) {
  PetscVector diagonal;
  require_modes(MatCreateVecs(matrix, diagonal.out(), nullptr));
  require_modes(MatGetDiagonal(matrix, diagonal.get()));
  const double* values = nullptr;
  require_modes(VecGetArrayRead(diagonal.get(), &values));
  Eigen::ArrayXd entries = Eigen::Map<const Eigen::ArrayXd>(values, rows);
  require_modes(VecRestoreArrayRead(diagonal.get(), &values));
  return entries;
}

void measure_residuals(const Matrices& matrices, Modes& modes) {
  const Columns inertia =
      multiply(matrices.mass.get(), modes.vectors) * modes.squared_frequencies.asDiagonal();
  const Columns residual = multiply(matrices.stiffness.get(), modes.vectors) - inertia;
  const Eigen::ArrayXd diagonal = local_diagonal(matrices.stiffness.get(), modes.vectors.rows());
  const Eigen::VectorXd scale = diagonal.rsqrt();
  Eigen::MatrixXd squares(5, modes.vectors.cols());
  squares.row(0) = residual.colwise().squaredNorm();
  squares.row(1) = inertia.colwise().squaredNorm();
  squares.row(2) = (scale.asDiagonal() * residual).colwise().squaredNorm();
  squares.row(3) = (scale.asDiagonal() * inertia).colwise().squaredNorm();
  // For the first mode: the sum of the terms that cancel each other in psi^T K psi.
  squares.row(4).setConstant((diagonal * modes.vectors.col(0).array().square()).sum());
  sum_over_ranks(squares);
  modes.residuals = (squares.row(0).array() / squares.row(1).array()).sqrt().matrix().transpose();
  modes.scaled_residual = std::sqrt((squares.row(2).array() / squares.row(3).array()).maxCoeff());
  modes.cancellation = modes.squared_frequencies[0] / squares(4, 0);
}

// A Rayleigh-Ritz step in the span of the last inverse iteration; it removes rounding errors along
// stiff modes.
void rotate_to_modes(const Matrices& matrices, Modes& modes) {
  const auto gram = [&](Mat matrix) {
    return inner_products(modes.vectors, multiply(matrix, modes.vectors));
  };
  const EigenPairs rotation = eigenpairs(gram(matrices.stiffness.get()), gram(matrices.mass.get()));
  modes.squared_frequencies = rotation.values;
  Columns rotated(modes.vectors.rows(), modes.vectors.cols());
  add_product(1.0, modes.vectors, rotation.vectors, 0.0, rotated);
  modes.vectors = std::move(rotated);
}

void keep_lowest(const Matrices& matrices, int count, Modes& modes) {
  if (modes.squared_frequencies.size() > count)
    modes.next_squared_frequency = modes.squared_frequencies[count];
  modes.squared_frequencies.conservativeResize(count);
  modes.vectors.conservativeResize(Eigen::NoChange, count);
  measure_residuals(matrices, modes);
}

constexpr double kMostRatio = 1e12;  // the remaining digits of 16 do not tell modes apart
constexpr double kLargest = 1e150;   // squares of larger numbers overflow

// The largest of K_ii, 1/K_ii, M_ii, 1/M_ii and of K_ii/M_ii and its inverse on this rank.
Eigen::ArrayXd largest_entries(const Matrices& matrices, Eigen::Index rows) {
  const Eigen::ArrayXd stiffness = local_diagonal(matrices.stiffness.get(), rows);
  const Eigen::ArrayXd mass = local_diagonal(matrices.mass.get(), rows);
  Eigen::ArrayXd largest = Eigen::ArrayXd::Zero(6);
  if (rows == 0) return largest;
  const Eigen::ArrayXd squares = stiffness / mass;
  int at = 0;
  for (const Eigen::ArrayXd* values : {&stiffness, &mass, &squares}) {
    largest[at++] = values->maxCoeff();
    largest[at++] = 1.0 / values->minCoeff();
  }
  return largest;
}

// Empty, or why double precision does not hold the modes, and what to do about it.
std::string range_problem(const Eigen::ArrayXd& largest) {
  if ((largest < kLargest).all() && largest[4] * largest[5] <= kMostRatio) return {};
  return "stiffness over mass, K_ii/M_ii, is " + number_text(1.0 / largest[5]) + " to " +
         number_text(largest[4]) +
         " (rad/s)^2 at single vertices, which is more than double precision holds: check --young, "
         "--density, --point-mass and --unit";
}

[[noreturn]] void give_up(const std::string& what, const std::string& problem) {
  throw Failure({ErrorKind::kSolver, what + "; " + problem});
}

Eigen::ArrayXd largest_entries_over_ranks(const Pencil& pencil) {
  Eigen::ArrayXd largest = largest_entries(pencil.matrices, pencil.rows());
  MPI_Allreduce(MPI_IN_PLACE, largest.data(), 6, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
  return largest;
}

// Numbers whose squares overflow give no modes, or modes that are not finite.
void require_representable(const Pencil& pencil) {
  const Eigen::ArrayXd largest = largest_entries_over_ranks(pencil);
  if (!(largest < kLargest).all()) give_up("the modes cannot be computed", range_problem(largest));
}

// Returns false if block Lanczos does not converge; SLEPc may still succeed.
bool solve_by_blocks(const Pencil& pencil, const ShiftedSolver& solver, int wanted, Modes& modes) {
  constexpr double kTolerance = 1e-10;  // the inverse iteration that follows squares it
  LanczosPairs pairs = block_lanczos(pencil, solver, wanted, kTolerance);
  if (pairs.exhausted) {
    if (const std::string problem = range_problem(largest_entries_over_ranks(pencil));
        !problem.empty())
      give_up("the modes cannot be computed: the solver finds no further direction", problem);
  }
  if (!pairs.converged) return false;
  modes.vectors = std::move(pairs.vectors);
  modes.solves = pairs.solves + wanted;
  modes.solver = "block Lanczos, shift-invert";
  return true;
}

// Computes `wanted` columns with a factor and refines them by one inverse iteration.
void solve_on_factor(const Pencil& pencil, ShiftedSolver& solver, int wanted, Modes& modes) {
  modes.factorisation = solver.package();
  // On a small mesh the basis would fill the space before blocks pay off.
  const bool by_blocks = !slepc_options_given() && pencil.all_rows() > 40 * wanted;
  if (by_blocks) solver.prepare(modes.shift);
  if (!by_blocks || !solve_by_blocks(pencil, solver, wanted, modes)) {
    SlepcModes found = krylov_schur_modes(pencil, solver, modes.shift, wanted);
    modes.vectors = std::move(found.vectors);
    modes.solver = std::move(found.solver);
    if (!found.factorisation.empty()) modes.factorisation = std::move(found.factorisation);
  }
  apply_inverse(pencil, solver, modes.vectors);
}

void solve_without_factor(const Pencil& pencil, ShiftedSolver& solver, int wanted, Modes& modes) {
  constexpr double kResidual = 1e-8;
  SlepcModes found = lobpcg_modes(pencil, modes.shift, wanted, kResidual);
  modes.vectors = std::move(found.vectors);
  modes.solver = std::move(found.solver);
  modes.factorisation = solver.package();
  solver.prepare(modes.shift);
}

}  // namespace

int available_modes(const Pencil& pencil) {
  return static_cast<int>(pencil.all_rows() - pencil.rigid.cols());
}

Modes compute_modes(const Pencil& pencil, ShiftedSolver& solver, double shift, int count) {
  const int available = available_modes(pencil);
  if (count < 1 || count > available)
    throw Failure(content_error(std::to_string(count) + " linear modes asked for, the mesh has " +
                                std::to_string(available) + " free dofs"));
  require_representable(pencil);
  const int wanted =
      std::min(count + 1, available);  // one extra mode gives the distance to the next one
  Modes modes;
  modes.shift = shift;
  try {
    if (solver.solves_unshifted())
      solve_without_factor(pencil, solver, wanted, modes);
    else
      solve_on_factor(pencil, solver, wanted, modes);
  } catch (const Failure& failure) {
    // Other ranks may not be here: the text is of this rank's rows.
    const std::string problem = range_problem(largest_entries(pencil.matrices, pencil.rows()));
    if (problem.empty() || failure.error().message.find("K_ii/M_ii") != std::string::npos) throw;
    give_up(failure.error().message, problem);
  }
  rotate_to_modes(pencil.matrices, modes);
  keep_lowest(pencil.matrices, count, modes);
  return modes;
}

Modes compute_modes_and_equals(const Pencil& pencil, ShiftedSolver& solver, double shift,
                               int count) {
  const int available = available_modes(pencil);
  Modes modes;
  // One extra mode shows whether a pair ends at the cut; only larger clusters need another run.
  for (int more : {1, 8, 32}) {
    modes = Modes();
    modes =
        compute_modes(pencil, solver, shift, std::max(count, std::min(count + more, available)));
    if (cut_of(modes, count, available).whole) break;
  }
  return modes;
}

}  // namespace tremolo
