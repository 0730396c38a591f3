#include "precompute/modes/slepc_modes.h"

#include <cmath>

#include "precompute/solver/multigrid.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

void require_slepc(PetscErrorCode code) {
  check_petsc(code, "compute the modes");
}

bool inner_options_given() {
  return petsc_options().find("-st_") != std::string::npos;
}

struct InnerSolver {
  ST transform = nullptr;
  KSP linear = nullptr;
  PC preconditioner = nullptr;
};

InnerSolver inner_solver(EPS eps) {
  InnerSolver inner;
  require_slepc(EPSGetST(eps, &inner.transform));
  require_slepc(STGetKSP(inner.transform, &inner.linear));
  require_slepc(KSPGetPC(inner.linear, &inner.preconditioner));
  return inner;
}

// Applies X = (K - sigma M)^-1 B as PETSc's shell preconditioner. Exceptions must not pass through
// PETSc and become an error code.
PetscErrorCode apply_shifted_solver(PC shell, Vec b, Vec x) {
  try {
    void* context = nullptr;
    require_slepc(PCShellGetContext(shell, &context));
    PetscInt rows = 0;
    const double* from = nullptr;
    double* to = nullptr;
    require_slepc(VecGetLocalSize(b, &rows));
    require_slepc(VecGetArrayRead(b, &from));
    require_slepc(VecGetArrayWrite(x, &to));
    static_cast<const ShiftedSolver*>(context)->solve(Eigen::Map<const Columns>(from, rows, 1),
                                                      Eigen::Map<Columns>(to, rows, 1));
    require_slepc(VecRestoreArrayWrite(x, &to));
    require_slepc(VecRestoreArrayRead(b, &from));
    return 0;
  } catch (const std::exception&) {
    return PETSC_ERR_LIB;
  }
}

// Sets up shift-invert with the shifted solver, or with a factor of PETSc's own if options ask for
// one.
void set_shift_invert(EPS eps, ShiftedSolver& solver) {
  require_slepc(EPSSetType(eps, EPSKRYLOVSCHUR));
  require_slepc(EPSSetWhichEigenpairs(eps, EPS_TARGET_MAGNITUDE));
  const InnerSolver first = inner_solver(eps);
  require_slepc(STSetType(first.transform, STSINVERT));
  // The pattern of M is a subset of that of K.
  require_slepc(STSetMatStructure(first.transform, SUBSET_NONZERO_PATTERN));
  const InnerSolver inner = inner_solver(eps);
  require_slepc(KSPSetType(inner.linear, KSPPREONLY));
  if (inner_options_given()) {
    const bool one = mpi_ranks() == 1;
    require_slepc(PCSetType(inner.preconditioner, PCCHOLESKY));
    require_slepc(
        PCFactorSetMatSolverType(inner.preconditioner, one ? MATSOLVERCHOLMOD : MATSOLVERMUMPS));
    if (one) require_slepc(PCFactorSetMatOrderingType(inner.preconditioner, MATORDERINGNATURAL));
  } else {
    require_slepc(PCSetType(inner.preconditioner, PCSHELL));
    require_slepc(PCShellSetContext(inner.preconditioner, &solver));
    require_slepc(PCShellSetApply(inner.preconditioner, apply_shifted_solver));
  }
}

// A deterministic start vector, so that the same mesh gives the same modes.
Columns start_vector(Eigen::Index rows, PetscInt first) {
  return Columns::NullaryExpr(rows, 1, [first](Eigen::Index row, Eigen::Index) {
    return 1.0 + 0.5 * std::sin(1.0 + 0.7 * static_cast<double>(first + row));
  });
}

// Returns the square root of M's mean diagonal entry, an estimate of |M x| for an M-normalised x.
double mass_scale(Mat mass) {
  PetscVector diagonal;
  require_slepc(MatCreateVecs(mass, diagonal.out(), nullptr));
  require_slepc(MatGetDiagonal(mass, diagonal.get()));
  PetscScalar sum = 0;
  PetscInt size = 0;
  require_slepc(VecSum(diagonal.get(), &sum));
  require_slepc(VecGetSize(diagonal.get(), &size));
  return std::sqrt(sum / static_cast<double>(size));
}

PetscErrorCode relative_to_inertia(EPS, PetscScalar value, PetscScalar, PetscReal residual,
                                   PetscReal* error, void* scale) {
  *error = residual / (std::abs(value) * *static_cast<const double*>(scale));
  return 0;
}

// A deterministic start block that contains smooth and rough motions.
Columns start_block(Eigen::Index rows, PetscInt first, Eigen::Index columns) {
  Columns block(rows, columns);
  for (Eigen::Index c = 0; c < columns; ++c)
    for (Eigen::Index row = 0; row < rows; ++row)
      block(row, c) =
          std::sin(0.7 * static_cast<double>(first + row) * (1.0 + 0.37 * static_cast<double>(c)) +
                   static_cast<double>(c));
  return block;
}

// Sets start vectors and deflation space; SLEPc keeps references to both.
void set_spaces(EPS eps, const Columns& start, const Columns& deflated) {
  const std::vector<PetscVector> starts = copied_vectors(start), away = copied_vectors(deflated);
  std::vector<Vec> from = handles_of(starts), rigid = handles_of(away);
  require_slepc(EPSSetInitialSpace(eps, static_cast<PetscInt>(from.size()), from.data()));
  if (!rigid.empty())
    require_slepc(EPSSetDeflationSpace(eps, static_cast<PetscInt>(rigid.size()), rigid.data()));
}

void set_pencil(EPS eps, const Pencil& pencil, int wanted) {
  require_slepc(EPSSetOperators(eps, pencil.stiffness(), pencil.mass()));
  require_slepc(EPSSetProblemType(eps, EPS_GHEP));
  require_slepc(EPSSetDimensions(eps, wanted, PETSC_DEFAULT, PETSC_DEFAULT));
}

PetscInt first_row(const Pencil& pencil) {
  PetscInt first = 0;
  require_slepc(MatGetOwnershipRange(pencil.stiffness(), &first, nullptr));
  return first;
}

SlepcModes solve_and_copy(EPS eps, const Pencil& pencil, int wanted) {
  require_slepc(EPSSetFromOptions(eps));
  require_slepc(EPSSolve(eps));
  PetscInt found = 0, iterations = 0;
  require_slepc(EPSGetConverged(eps, &found));
  require_slepc(EPSGetIterationNumber(eps, &iterations));
  EPSType type = nullptr;
  require_slepc(EPSGetType(eps, &type));
  if (found < wanted)
    throw Failure({ErrorKind::kSolver, "SLEPc (" + std::string(type) + ") found " +
                                           std::to_string(found) + " of " + std::to_string(wanted) +
                                           " modes in " + std::to_string(iterations) +
                                           " iterations"});
  SlepcModes modes;
  modes.solver = "SLEPc " + std::string(type) + ", " + std::to_string(iterations) + " iterations";
  modes.squared_frequencies.resize(wanted);
  modes.vectors.resize(pencil.rows(), wanted);
  const std::vector<PetscVector> columns = as_vectors(modes.vectors);
  for (int i = 0; i < wanted; ++i) {
    PetscScalar value = 0;
    Vec column = columns[i].get();
    require_slepc(EPSGetEigenpair(eps, i, &value, nullptr, column, nullptr));
    modes.squared_frequencies[i] = value;
  }
  return modes;
}

}  // namespace

bool slepc_options_given() {
  return inner_options_given() || petsc_options().find("-eps_") != std::string::npos;
}

SlepcModes krylov_schur_modes(const Pencil& pencil, ShiftedSolver& solver, double sigma,
                              int wanted) {
  if (inner_options_given())
    solver.release();  // only one factor is kept at a time
  else
    solver.prepare(sigma);
  SlepcModes modes;
  {
    PetscEigenSolver keeper;
    require_slepc(EPSCreate(PETSC_COMM_WORLD, keeper.out()));
    EPS eps = keeper.get();
    set_pencil(eps, pencil, wanted);
    set_shift_invert(eps, solver);
    require_slepc(EPSSetTarget(eps, sigma));
    // A tolerance of the shift-inverted problem; it gives residuals of the pencil near rounding.
    require_slepc(EPSSetTolerances(eps, 1e-13, 500));
    set_spaces(eps, start_vector(pencil.rows(), first_row(pencil)), pencil.rigid);
    modes = solve_and_copy(eps, pencil, wanted);
    modes.solver = "SLEPc Krylov-Schur, shift-invert";
    if (inner_options_given()) {
      MatSolverType package = nullptr;
      require_slepc(PCFactorGetMatSolverType(inner_solver(eps).preconditioner, &package));
      modes.factorisation = package == nullptr ? "petsc" : package;
    }
  }
  solver.prepare(sigma);
  return modes;
}

SlepcModes lobpcg_modes(const Pencil& pencil, double sigma, int wanted, double residual) {
  PetscEigenSolver keeper;
  require_slepc(EPSCreate(PETSC_COMM_WORLD, keeper.out()));
  EPS eps = keeper.get();
  set_pencil(eps, pencil, wanted);
  require_slepc(EPSSetType(eps, EPSLOBPCG));
  require_slepc(EPSSetWhichEigenpairs(eps, EPS_SMALLEST_REAL));
  require_slepc(EPSLOBPCGSetBlockSize(eps, wanted));
  require_slepc(EPSSetTolerances(eps, residual, 1000));
  double scale = mass_scale(pencil.mass());
  require_slepc(EPSSetConvergenceTestFunction(eps, relative_to_inertia, &scale, nullptr));
  const PetscMatrix shifted =
      sigma == 0.0 ? PetscMatrix() : shifted_stiffness(pencil.matrices, sigma);
  Mat definite = sigma == 0.0 ? pencil.stiffness() : shifted.get();
  ST transform = nullptr;
  require_slepc(EPSGetST(eps, &transform));
  require_slepc(STSetType(transform, STPRECOND));
  const InnerSolver inner = inner_solver(eps);
  require_slepc(KSPSetType(inner.linear, KSPPREONLY));
  require_slepc(STSetPreconditionerMat(inner.transform, definite));
  set_multigrid(inner.preconditioner, definite, pencil.positions);
  const Eigen::Index rows = pencil.rows();
  set_spaces(eps, start_block(rows, first_row(pencil), wanted), pencil.rigid);
  return solve_and_copy(eps, pencil, wanted);
}

}  // namespace tremolo
