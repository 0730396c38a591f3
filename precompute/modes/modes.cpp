#include "precompute/modes/modes.h"

#include <algorithm>
#include <cmath>

#include "precompute/dense/dense_decompositions.h"
#include "precompute/modes/block_lanczos.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

void require(PetscErrorCode code) {
  check_petsc(code, "compute the modes");
}

// The nodes are already in METIS's nested dissection: while this lives, CHOLMOD takes that order
// and tries no other, METIS's on the graph of the dofs above all.
class OnlyNaturalOrder {
 public:
  OnlyNaturalOrder() {
    require(PetscOptionsHasName(nullptr, nullptr, kMethods, &given_));
    if (!given_) require(PetscOptionsSetValue(nullptr, kMethods, "1"));
  }
  ~OnlyNaturalOrder() {
    if (!given_) PetscOptionsClearValue(nullptr, kMethods);
  }
  OnlyNaturalOrder(const OnlyNaturalOrder&) = delete;
  OnlyNaturalOrder& operator=(const OnlyNaturalOrder&) = delete;

 private:
  static constexpr const char* kMethods = "-st_mat_cholmod_nmethods";
  PetscBool given_ = PETSC_FALSE;
};

// Shift-invert on a Cholesky factor: CHOLMOD's on one rank, MUMPS's on several.
void choose_factorisation(EPS solver, LinearSolver package) {
  ST transform = nullptr;
  KSP linear = nullptr;
  PC factor = nullptr;
  require(EPSGetST(solver, &transform));
  require(STSetType(transform, STSINVERT));
  // M's pattern lies inside K's.
  require(STSetMatStructure(transform, SUBSET_NONZERO_PATTERN));
  require(STGetKSP(transform, &linear));
  require(KSPSetType(linear, KSPPREONLY));
  require(KSPGetPC(linear, &factor));
  require(PCSetType(factor, PCCHOLESKY));
  if (package == LinearSolver::kCholmod && mpi_ranks() == 1) {
    require(PCFactorSetMatSolverType(factor, MATSOLVERCHOLMOD));
    require(PCFactorSetMatOrderingType(factor, MATORDERINGNATURAL));
  } else {
    require(PCFactorSetMatSolverType(factor, MATSOLVERMUMPS));
  }
}

// A start vector without chance in it: the same mesh gives the same modes.
void set_start_vector(EPS solver, Mat stiffness) {
  PetscVector start;
  require(MatCreateVecs(stiffness, start.out(), nullptr));
  PetscInt first = 0, last = 0;
  require(VecGetOwnershipRange(start.get(), &first, &last));
  for (PetscInt row = first; row < last; ++row)
    require(VecSetValue(start.get(), row, 1.0 + 0.5 * std::sin(1.0 + 0.7 * row), INSERT_VALUES));
  require(VecAssemblyBegin(start.get()));
  require(VecAssemblyEnd(start.get()));
  Vec vectors[] = {start.get()};
  require(EPSSetInitialSpace(solver, 1, vectors));
}

void set_up(EPS solver, const Matrices& matrices, int wanted, const Columns& rigid, double shift,
            LinearSolver package) {
  require(EPSSetOperators(solver, matrices.stiffness.get(), matrices.mass.get()));
  require(EPSSetProblemType(solver, EPS_GHEP));
  require(EPSSetType(solver, EPSKRYLOVSCHUR));
  require(EPSSetWhichEigenpairs(solver, EPS_TARGET_MAGNITUDE));
  require(EPSSetTarget(solver, shift));
  require(EPSSetDimensions(solver, wanted, PETSC_DEFAULT, PETSC_DEFAULT));
  // Of the shift-inverted problem; leaves residuals of the pencil near rounding.
  require(EPSSetTolerances(solver, 1e-13, 500));
  choose_factorisation(solver, package);
  set_start_vector(solver, matrices.stiffness.get());
  std::vector<PetscVector> deflated = as_vectors(rigid);
  std::vector<Vec> raw;
  for (const PetscVector& vector : deflated) raw.push_back(vector.get());
  if (!raw.empty())
    require(EPSSetDeflationSpace(solver, static_cast<PetscInt>(raw.size()), raw.data()));
  require(EPSSetFromOptions(solver));
  const OnlyNaturalOrder natural;
  require(EPSSetUp(solver));
}

void copy_pairs(EPS solver, const Matrices& matrices, int count, Modes& modes) {
  PetscVector vector;
  require(MatCreateVecs(matrices.stiffness.get(), vector.out(), nullptr));
  PetscInt rows = 0;
  require(VecGetLocalSize(vector.get(), &rows));
  modes.squared_frequencies.resize(count);
  modes.vectors.resize(rows, count);
  for (int i = 0; i < count; ++i) {
    PetscScalar value = 0;
    require(EPSGetEigenpair(solver, i, &value, nullptr, vector.get(), nullptr));
    const double* entries = nullptr;
    require(VecGetArrayRead(vector.get(), &entries));
    modes.vectors.col(i) = Eigen::Map<const Eigen::VectorXd>(entries, rows);
    require(VecRestoreArrayRead(vector.get(), &entries));
    modes.squared_frequencies[i] = value;
  }
}

Eigen::ArrayXd local_diagonal(Mat matrix, Eigen::Index rows) {
  PetscVector diagonal;
  require(MatCreateVecs(matrix, diagonal.out(), nullptr));
  require(MatGetDiagonal(matrix, diagonal.get()));
  const double* values = nullptr;
  require(VecGetArrayRead(diagonal.get(), &values));
  Eigen::ArrayXd entries = Eigen::Map<const Eigen::ArrayXd>(values, rows);
  require(VecRestoreArrayRead(diagonal.get(), &values));
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
  // Of the first mode: the terms that cancel each other in psi^T K psi.
  squares.row(4).setConstant((diagonal * modes.vectors.col(0).array().square()).sum());
  sum_over_ranks(squares);
  modes.residuals = (squares.row(0).array() / squares.row(1).array()).sqrt().matrix().transpose();
  modes.scaled_residual = std::sqrt((squares.row(2).array() / squares.row(3).array()).maxCoeff());
  modes.cancellation = modes.squared_frequencies[0] / squares(4, 0);
}

void keep_factor(Modes& modes) {
  ST transform = nullptr;
  KSP linear = nullptr;
  PC factor = nullptr;
  MatSolverType package = nullptr;
  require(EPSGetST(modes.keeper.get(), &transform));
  require(STGetKSP(transform, &linear));
  require(KSPGetPC(linear, &factor));
  require(PCFactorGetMatrix(factor, &modes.factor));
  require(PCFactorGetMatSolverType(factor, &package));
  modes.factorisation = package == nullptr ? "petsc" : package;
  modes.solver = "SLEPc Krylov-Schur, shift-invert";
}

void solve_by_slepc(const Matrices& matrices, int wanted, const Columns& rigid,
                    LinearSolver package, Modes& modes) {
  require(EPSCreate(PETSC_COMM_WORLD, modes.keeper.out()));
  EPS solver = modes.keeper.get();
  set_up(solver, matrices, wanted, rigid, modes.shift, package);
  require(EPSSolve(solver));
  PetscInt found = 0;
  require(EPSGetConverged(solver, &found));
  if (found < wanted)
    throw Failure({ErrorKind::kSolver, "SLEPc found " + std::to_string(found) + " of " +
                                           std::to_string(wanted) + " modes"});
  copy_pairs(solver, matrices, wanted, modes);
  keep_factor(modes);
}

// Whether the user told the eigensolver or its inner solver something.
bool solver_options_given() {
  const std::string text = petsc_options();
  return text.find("-eps_") != std::string::npos || text.find("-st_") != std::string::npos;
}

// MUMPS's factor of K - shift M, on all ranks.
void factorise_by_mumps(const Matrices& matrices, Modes& modes) {
  const PetscMatrix shifted = shifted_stiffness(matrices, modes.shift);
  Mat matrix = shifted.get();
  MatFactorInfo info;
  require(MatGetFactor(matrix, MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY, modes.mumps.out()));
  require(MatFactorInfoInitialize(&info));
  require(MatCholeskyFactorSymbolic(modes.mumps.get(), matrix, nullptr, &info));
  require(MatCholeskyFactorNumeric(modes.mumps.get(), matrix, &info));
  require_factorised(modes.mumps.get());
  modes.factor = modes.mumps.get();
}

// The factor of K - shift M; none when that is not positive definite.
std::unique_ptr<SparseCholesky> factorise(const Matrices& matrices, double shift) {
  const PetscMatrix shifted = shift == 0.0 ? PetscMatrix() : shifted_stiffness(matrices, shift);
  Mat matrix = shift == 0.0 ? matrices.stiffness.get() : shifted.get();
  try {
    return std::make_unique<SparseCholesky>(sparse_rows(matrix));
  } catch (const Failure& failure) {
    if (failure.error().kind != ErrorKind::kSolver) throw;
    return nullptr;
  }
}

// The best values and vectors in the span of what a last inverse iteration left; that takes out
// what rounding has left of stiff motion.
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

bool is_in_one_process(LinearSolver solver) {
  return solver == LinearSolver::kCholmod && mpi_ranks() == 1;
}

// False when the matrix or the spectrum is not fit for it: SLEPc may try.
bool solve_by_blocks(const Matrices& matrices, int wanted, const Columns& rigid, unsigned threads,
                     LinearSolver solver, Modes& modes) {
  const bool one = is_in_one_process(solver);
  if (one)
    modes.cholesky = factorise(matrices, modes.shift);
  else
    factorise_by_mumps(matrices, modes);
  if (one && modes.cholesky == nullptr) return false;
  Mat mass = matrices.mass.get();
  const Pencil pencil = one ? thread_pencil(mass, *modes.cholesky, rigid, threads)
                            : petsc_pencil(mass, modes.factor, rigid);
  constexpr double kTolerance = 1e-10;  // the refinement squares it
  LanczosPairs pairs = block_lanczos(pencil, wanted, kTolerance);
  if (!pairs.converged) {
    release_solver(modes);
    return false;
  }
  modes.vectors = std::move(pairs.vectors);
  apply_inverse(pencil, modes.vectors);
  rotate_to_modes(matrices, modes);
  modes.solves = pairs.solves + wanted;
  modes.factorisation = one ? "cholmod" : "mumps";
  modes.solver = "block Lanczos, shift-invert";
  return true;
}

// One more than asked for tells how far the next one is. Throws Failure (kContent).
int modes_wanted(const Matrices& matrices, int count, const Columns& rigid) {
  PetscInt size = 0;
  require(MatGetSize(matrices.stiffness.get(), &size, nullptr));
  const int available = static_cast<int>(size - rigid.cols());
  if (count < 1 || count > available)
    throw Failure(content_error(std::to_string(count) + " linear modes asked for, the mesh has " +
                                std::to_string(available) + " free dofs"));
  return std::min(count + 1, available);
}

void keep_the_lowest(const Matrices& matrices, int count, Modes& modes) {
  if (modes.squared_frequencies.size() > count)
    modes.next_squared_frequency = modes.squared_frequencies[count];
  modes.squared_frequencies.conservativeResize(count);
  modes.vectors.conservativeResize(Eigen::NoChange, count);
  measure_residuals(matrices, modes);
}

}  // namespace

Modes compute_modes(const Matrices& matrices, int count, const Columns& rigid, double shift,
                    unsigned threads, LinearSolver solver) {
  Modes modes;
  modes.shift = shift;
  const int wanted = modes_wanted(matrices, count, rigid);
  PetscInt size = 0;
  require(MatGetSize(matrices.stiffness.get(), &size, nullptr));
  // A basis that fills the space has no room for blocks.
  const bool by_blocks = !solver_options_given() && size > 40 * wanted;
  if (!by_blocks || !solve_by_blocks(matrices, wanted, rigid, threads, solver, modes)) {
    solve_by_slepc(matrices, wanted, rigid, solver, modes);
    apply_inverse(petsc_pencil(matrices.mass.get(), modes.factor, rigid), modes.vectors);
    rotate_to_modes(matrices, modes);
  }
  keep_the_lowest(matrices, count, modes);
  return modes;
}

Modes compute_modes_iteratively(const Matrices& matrices, int count, const Columns& rigid,
                                double shift, const std::vector<Eigen::Vector3d>& positions) {
  Modes modes;
  modes.shift = shift;
  const int wanted = modes_wanted(matrices, count, rigid);
  constexpr double kResidual = 1e-8;
  IterativeModes found = iterative_modes(matrices, positions, wanted, rigid, shift, kResidual);
  modes.squared_frequencies = std::move(found.squared_frequencies);
  modes.vectors = std::move(found.vectors);
  rotate_to_modes(matrices, modes);
  modes.iterative =
      std::make_unique<IterativeSolver>(make_iterative_solver(matrices, positions, rigid, shift));
  modes.factorisation = "none: multigrid (gamg)";
  modes.solver = found.solver + ", " + std::to_string(found.iterations) + " iterations";
  keep_the_lowest(matrices, count, modes);
  return modes;
}

void release_solver(Modes& modes) {
  modes.cholesky.reset();
  modes.iterative.reset();
  modes.keeper = PetscEigenSolver();
  modes.mumps = PetscMatrix();
  modes.factor = nullptr;
}

void restore_solver(const Matrices& matrices, const Columns& rigid, LinearSolver solver,
                    const std::vector<Eigen::Vector3d>& positions, Modes& modes) {
  if (modes.cholesky != nullptr || modes.factor != nullptr || modes.iterative != nullptr) return;
  if (solver == LinearSolver::kIterative) {
    modes.iterative = std::make_unique<IterativeSolver>(
        make_iterative_solver(matrices, positions, rigid, modes.shift));
  } else if (modes.solves > 0 && !is_in_one_process(solver)) {
    factorise_by_mumps(matrices, modes);
  } else if (modes.solves > 0) {
    modes.cholesky = factorise(matrices, modes.shift);
    if (modes.cholesky == nullptr)
      throw Failure({ErrorKind::kSolver, "the stiffness is not positive definite any more"});
  } else {
    require(EPSCreate(PETSC_COMM_WORLD, modes.keeper.out()));
    set_up(modes.keeper.get(), matrices, static_cast<int>(modes.vectors.cols()), rigid, modes.shift,
           solver);
    keep_factor(modes);
  }
}

}  // namespace tremolo
