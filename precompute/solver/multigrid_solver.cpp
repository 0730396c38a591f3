// K^-1 by conjugate gradients, preconditioned with smoothed aggregation multigrid (PETSc's GAMG,
// with the rigid motions as near null space). Memory grows linearly with the mesh.
#include <algorithm>

#include <Eigen/Cholesky>

#include "precompute/solver/multigrid.h"
#include "precompute/solver/shifted_solver.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

using PetscLinearSolver = PetscHandle<KSP, KSPDestroy>;

constexpr double kSolveTolerance = 1e-11;  // relative to |b|, in the preconditioned norm
constexpr int kMostIterations = 1000;

void require_iteration(PetscErrorCode code) {
  check_petsc(code, "solve by iteration");
}

// Returns a basis of the same span that is orthonormal in the Euclidean inner product.
Columns plainly_orthonormal(Columns columns) {
  for (int pass = 0; pass < 2; ++pass) {
    const Eigen::MatrixXd gram = inner_products(columns, columns);
    columns = gram.llt().matrixU().solve<Eigen::OnTheRight>(columns).eval();
  }
  return columns;
}

void set_null_space(Mat stiffness, const Columns& rigid) {
  if (rigid.cols() == 0) return;
  const std::vector<PetscVector> own = copied_vectors(plainly_orthonormal(rigid));
  std::vector<Vec> raw = handles_of(own);
  MatNullSpace space = nullptr;
  require_iteration(MatNullSpaceCreate(PETSC_COMM_WORLD, PETSC_FALSE,
                                       static_cast<PetscInt>(raw.size()), raw.data(), &space));
  require_iteration(MatSetNullSpace(stiffness, space));
  require_iteration(MatNullSpaceDestroy(&space));
}

// With the rigid motions as near null space, coarse grids represent them.
void set_near_null_space(Mat matrix, const std::vector<Eigen::Vector3d>& positions) {
  PetscVector coordinates;
  require_iteration(MatCreateVecs(matrix, coordinates.out(), nullptr));
  require_iteration(VecSetBlockSize(coordinates.get(), 3));
  double* values = nullptr;
  require_iteration(VecGetArrayWrite(coordinates.get(), &values));
  for (const Eigen::Vector3d& x : positions) values = std::copy(x.data(), x.data() + 3, values);
  values -= 3 * positions.size();
  require_iteration(VecRestoreArrayWrite(coordinates.get(), &values));
  MatNullSpace motions = nullptr;
  require_iteration(MatNullSpaceCreateRigidBody(coordinates.get(), &motions));
  require_iteration(MatSetNearNullSpace(matrix, motions));
  require_iteration(MatNullSpaceDestroy(&motions));
}

class MultigridSolver final : public ShiftedSolver {
 public:
  explicit MultigridSolver(const Pencil& pencil) : pencil_(pencil) {}

  // The K of a free body is singular: right-hand sides must be self-balancing, and the
  // preconditioner is built from K - sigma M.
  void solve(const ColumnsRef& b, ColumnsOut x) const override {
    const Columns loads = b;
    Columns solution(loads.rows(), loads.cols());
    const std::vector<PetscVector> from = as_vectors(loads), to = as_vectors(solution);
    for (std::size_t c = 0; c < from.size(); ++c) {
      require_iteration(KSPSolve(gradients_.get(), from[c].get(), to[c].get()));
      require_converged();
    }
    x = solution;
  }
  bool solves_unshifted() const override { return true; }

  InertiaCount count_negative(double /*sigma*/, double /*bound*/, double /*growth*/) override {
    throw Failure({ErrorKind::kSolver,
                   "counting modes by inertia needs a factor; --solver cholmod or mumps"});
  }

  std::string package() const override { return "none: multigrid (gamg)"; }

 private:
  void factorise(double sigma) override {
    Mat stiffness = pencil_.stiffness();
    if (sigma != 0.0) shifted_ = shifted_stiffness(pencil_.matrices, sigma);
    Mat definite = sigma == 0.0 ? stiffness : shifted_.get();
    set_null_space(stiffness, pencil_.rigid);
    require_iteration(KSPCreate(PETSC_COMM_WORLD, gradients_.out()));
    KSP ksp = gradients_.get();
    require_iteration(KSPSetOptionsPrefix(ksp, "cg_"));
    require_iteration(KSPSetOperators(ksp, stiffness, definite));
    require_iteration(KSPSetType(ksp, KSPCG));
    require_iteration(
        KSPSetTolerances(ksp, kSolveTolerance, 1e-300, PETSC_DEFAULT, kMostIterations));
    PC preconditioner = nullptr;
    require_iteration(KSPGetPC(ksp, &preconditioner));
    set_multigrid(preconditioner, definite, pencil_.positions);
    require_iteration(KSPSetFromOptions(ksp));
    require_iteration(KSPSetUp(ksp));
  }
  void free_factor() override {
    gradients_ = PetscLinearSolver();
    shifted_ = PetscMatrix();
  }

  void require_converged() const {
    KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
    PetscInt iterations = 0;
    require_iteration(KSPGetConvergedReason(gradients_.get(), &reason));
    require_iteration(KSPGetIterationNumber(gradients_.get(), &iterations));
    if (reason >= 0) return;
    throw Failure({ErrorKind::kSolver,
                   std::string("conjugate gradients with multigrid did not converge (") +
                       KSPConvergedReasons[reason] + " after " + std::to_string(iterations) +
                       " iterations): is the mesh extremely thin or uneven? --solver cholmod or "
                       "mumps needs more memory and no iteration"});
  }

  const Pencil& pencil_;
  PetscMatrix shifted_;  // K - sigma M; empty if sigma = 0
  PetscLinearSolver gradients_;
};

}  // namespace

void set_multigrid(PC preconditioner, Mat definite, const std::vector<Eigen::Vector3d>& positions) {
  set_near_null_space(definite, positions);
  require_iteration(PCSetType(preconditioner, PCGAMG));
  require_iteration(PCGAMGSetType(preconditioner, PCGAMGAGG));
  require_iteration(PCGAMGSetNSmooths(preconditioner, 1));
}

std::unique_ptr<ShiftedSolver> make_multigrid_solver(const Pencil& pencil) {
  return std::make_unique<MultigridSolver>(pencil);
}

}  // namespace tremolo
