#include "precompute/solver/iterative_solver.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "precompute/system/failure.h"

namespace tremolo {
namespace {

void require(PetscErrorCode code) {
  check_petsc(code, "solve by iteration");
}

std::vector<Vec> handles(const std::vector<PetscVector>& vectors) {
  std::vector<Vec> raw;
  for (const PetscVector& vector : vectors) raw.push_back(vector.get());
  return raw;
}

// Orthonormal in the plain inner product, the same span.
Columns plainly_orthonormal(Columns columns) {
  for (int pass = 0; pass < 2; ++pass) {
    const Eigen::MatrixXd gram = inner_products(columns, columns);
    columns = gram.llt().matrixU().solve<Eigen::OnTheRight>(columns).eval();
  }
  return columns;
}

void set_null_space(Mat stiffness, const Columns& rigid) {
  if (rigid.cols() == 0) return;
  const Columns basis = plainly_orthonormal(rigid);
  const std::vector<PetscVector> vectors = as_vectors(basis);
  std::vector<PetscVector> own(vectors.size());
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    require(VecDuplicate(vectors[i].get(), own[i].out()));
    require(VecCopy(vectors[i].get(), own[i].get()));
  }
  std::vector<Vec> raw = handles(own);
  MatNullSpace space = nullptr;
  require(MatNullSpaceCreate(PETSC_COMM_WORLD, PETSC_FALSE, static_cast<PetscInt>(raw.size()),
                             raw.data(), &space));
  require(MatSetNullSpace(stiffness, space));
  require(MatNullSpaceDestroy(&space));
}

// Coarse grids of the multigrid on this matrix will represent the six rigid motions.
void set_near_null_space(Mat matrix, const std::vector<Eigen::Vector3d>& positions) {
  PetscVector coordinates;
  require(MatCreateVecs(matrix, coordinates.out(), nullptr));
  require(VecSetBlockSize(coordinates.get(), 3));
  double* values = nullptr;
  require(VecGetArrayWrite(coordinates.get(), &values));
  for (const Eigen::Vector3d& x : positions) values = std::copy(x.data(), x.data() + 3, values);
  values -= 3 * positions.size();
  require(VecRestoreArrayWrite(coordinates.get(), &values));
  MatNullSpace motions = nullptr;
  require(MatNullSpaceCreateRigidBody(coordinates.get(), &motions));
  require(MatSetNearNullSpace(matrix, motions));
  require(MatNullSpaceDestroy(&motions));
}

void set_multigrid(PC preconditioner) {
  require(PCSetType(preconditioner, PCGAMG));
  require(PCGAMGSetType(preconditioner, PCGAMGAGG));
  require(PCGAMGSetNSmooths(preconditioner, 1));
}

// sqrt of the mean diagonal entry of M: |M x| of an M-normalised x, about.
double mass_scale(Mat mass) {
  PetscVector diagonal;
  require(MatCreateVecs(mass, diagonal.out(), nullptr));
  require(MatGetDiagonal(mass, diagonal.get()));
  PetscScalar sum = 0;
  PetscInt size = 0;
  require(VecSum(diagonal.get(), &sum));
  require(VecGetSize(diagonal.get(), &size));
  return std::sqrt(sum / static_cast<double>(size));
}

PetscErrorCode relative_to_inertia(EPS, PetscScalar value, PetscScalar, PetscReal residual,
                                   PetscReal* error, void* scale) {
  *error = residual / (std::abs(value) * *static_cast<const double*>(scale));
  return 0;
}

// Nodes start from smooth and rough motions alike, without chance.
Columns start_block(Eigen::Index rows, PetscInt first, Eigen::Index columns) {
  Columns block(rows, columns);
  for (Eigen::Index c = 0; c < columns; ++c)
    for (Eigen::Index row = 0; row < rows; ++row)
      block(row, c) =
          std::sin(0.7 * static_cast<double>(first + row) * (1.0 + 0.37 * static_cast<double>(c)) +
                   static_cast<double>(c));
  return block;
}

}  // namespace

IterativeSolver make_iterative_solver(const Matrices& matrices,
                                      const std::vector<Eigen::Vector3d>& positions,
                                      const Columns& rigid, double shift) {
  IterativeSolver solver;
  Mat stiffness = matrices.stiffness.get();
  if (shift != 0.0) solver.shifted = shifted_stiffness(matrices, shift);
  Mat definite = shift == 0.0 ? stiffness : solver.shifted.get();
  set_null_space(stiffness, rigid);
  require(KSPCreate(PETSC_COMM_WORLD, solver.conjugate_gradients.out()));
  KSP ksp = solver.conjugate_gradients.get();
  require(KSPSetOptionsPrefix(ksp, "cg_"));
  require(KSPSetOperators(ksp, stiffness, definite));
  require(KSPSetType(ksp, KSPCG));
  require(KSPSetTolerances(ksp, kSolveTolerance, 1e-300, PETSC_DEFAULT, 1000));
  PC preconditioner = nullptr;
  require(KSPGetPC(ksp, &preconditioner));
  set_near_null_space(definite, positions);
  set_multigrid(preconditioner);
  require(KSPSetFromOptions(ksp));
  require(KSPSetUp(ksp));
  return solver;
}

Columns solve(IterativeSolver& solver, const Columns& loads) {
  Columns solution(loads.rows(), loads.cols());
  const std::vector<PetscVector> from = as_vectors(loads), to = as_vectors(solution);
  KSP ksp = solver.conjugate_gradients.get();
  for (std::size_t c = 0; c < from.size(); ++c) {
    require(KSPSolve(ksp, from[c].get(), to[c].get()));
    KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
    PetscInt iterations = 0;
    require(KSPGetConvergedReason(ksp, &reason));
    require(KSPGetIterationNumber(ksp, &iterations));
    if (reason < 0)
      throw Failure({ErrorKind::kSolver,
                     std::string("conjugate gradients with multigrid did not converge (") +
                         KSPConvergedReasons[reason] + " after " + std::to_string(iterations) +
                         " iterations): is the mesh extremely thin or uneven? --solver cholmod or "
                         "mumps needs more memory and no iteration"});
  }
  return solution;
}

IterativeModes iterative_modes(const Matrices& matrices,
                               const std::vector<Eigen::Vector3d>& positions, int wanted,
                               const Columns& rigid, double shift, double residual) {
  PetscEigenSolver keeper;
  require(EPSCreate(PETSC_COMM_WORLD, keeper.out()));
  EPS eps = keeper.get();
  require(EPSSetOperators(eps, matrices.stiffness.get(), matrices.mass.get()));
  require(EPSSetProblemType(eps, EPS_GHEP));
  require(EPSSetType(eps, EPSLOBPCG));
  require(EPSSetWhichEigenpairs(eps, EPS_SMALLEST_REAL));
  require(EPSSetDimensions(eps, wanted, PETSC_DEFAULT, PETSC_DEFAULT));
  require(EPSLOBPCGSetBlockSize(eps, wanted));
  require(EPSSetTolerances(eps, residual, 1000));
  double scale = mass_scale(matrices.mass.get());
  require(EPSSetConvergenceTestFunction(eps, relative_to_inertia, &scale, nullptr));

  ST transform = nullptr;
  KSP inner = nullptr;
  PC multigrid = nullptr;
  const PetscMatrix shifted = shift == 0.0 ? PetscMatrix() : shifted_stiffness(matrices, shift);
  require(EPSGetST(eps, &transform));
  require(STSetType(transform, STPRECOND));
  require(STGetKSP(transform, &inner));
  require(KSPSetType(inner, KSPPREONLY));
  Mat definite = shift == 0.0 ? matrices.stiffness.get() : shifted.get();
  set_near_null_space(definite, positions);
  require(STSetPreconditionerMat(transform, definite));
  require(KSPGetPC(inner, &multigrid));
  set_multigrid(multigrid);

  PetscInt first = 0, last = 0;
  require(MatGetOwnershipRange(matrices.stiffness.get(), &first, &last));
  const Columns start = start_block(last - first, first, wanted);
  const std::vector<PetscVector> starts = as_vectors(start), deflated = as_vectors(rigid);
  std::vector<Vec> raw = handles(starts), away = handles(deflated);
  require(EPSSetInitialSpace(eps, static_cast<PetscInt>(raw.size()), raw.data()));
  if (!away.empty())
    require(EPSSetDeflationSpace(eps, static_cast<PetscInt>(away.size()), away.data()));
  require(EPSSetFromOptions(eps));
  require(EPSSolve(eps));
  PetscInt found = 0, iterations = 0;
  require(EPSGetConverged(eps, &found));
  require(EPSGetIterationNumber(eps, &iterations));
  if (found < wanted)
    throw Failure({ErrorKind::kSolver, "LOBPCG found " + std::to_string(found) + " of " +
                                           std::to_string(wanted) + " modes in " +
                                           std::to_string(iterations) + " iterations"});
  IterativeModes modes;
  EPSType type = nullptr;
  require(EPSGetType(eps, &type));
  modes.solver = std::string("SLEPc ") + type;
  modes.iterations = static_cast<int>(iterations);
  modes.squared_frequencies.resize(wanted);
  modes.vectors.resize(last - first, wanted);
  const std::vector<PetscVector> columns = as_vectors(modes.vectors);
  for (int i = 0; i < wanted; ++i) {
    PetscScalar value = 0;
    require(EPSGetEigenpair(eps, i, &value, nullptr, columns[static_cast<std::size_t>(i)].get(),
                            nullptr));
    modes.squared_frequencies[i] = value;
  }
  return modes;
}

}  // namespace tremolo
