// K - sigma M by MUMPS's factor, distributed over the ranks.
#include "precompute/solver/shifted_solver.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

void require_mumps(PetscErrorCode code) {
  check_petsc(code, "factorise by MUMPS");
}

PetscMatrix mumps_factor(Mat matrix) {
  PetscMatrix factor;
  require_mumps(MatGetFactor(matrix, MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY, factor.out()));
  return factor;
}

void factorise(Mat matrix, Mat factor) {
  MatFactorInfo info;
  require_mumps(MatFactorInfoInitialize(&info));
  require_mumps(MatCholeskyFactorSymbolic(factor, matrix, nullptr, &info));
  require_mumps(MatCholeskyFactorNumeric(factor, matrix, &info));
  require_factorised(factor);
}

class MumpsSolver final : public ShiftedSolver {
 public:
  explicit MumpsSolver(const Pencil& pencil) : pencil_(pencil) {}

  void solve(const ColumnsRef& b, ColumnsOut x) const override {
    const Columns load = b;
    Columns solution(load.rows(), load.cols());
    const PetscMatrix from = as_dense(load), to = as_dense(solution);
    require_mumps(MatMatSolve(factor_.get(), from.get(), to.get()));
    x = solution;
  }

  InertiaCount count_negative(double /*sigma*/, double bound, double /*most_growth*/) override {
    release();
    return count_negative_by_mumps(pencil_.matrices, bound);
  }

  std::string package() const override { return "mumps"; }

 private:
  void factorise(double sigma) override {
    const PetscMatrix shifted = shifted_stiffness(pencil_.matrices, sigma);
    factor_ = mumps_factor(shifted.get());
    tremolo::factorise(shifted.get(), factor_.get());
  }
  void free_factor() override { factor_ = PetscMatrix(); }

  const Pencil& pencil_;
  PetscMatrix factor_;
};

}  // namespace

std::unique_ptr<ShiftedSolver> make_mumps_solver(const Pencil& pencil) {
  return std::make_unique<MumpsSolver>(pencil);
}

InertiaCount count_negative_by_mumps(const Matrices& matrices, double bound) {
  const PetscMatrix shifted = shifted_stiffness(matrices, bound);
  // The matrix is symmetric but indefinite, and MUMPS must not treat it as positive definite.
  require_mumps(MatSetOption(shifted.get(), MAT_SPD, PETSC_FALSE));
  require_mumps(MatSetOption(shifted.get(), MAT_SYMMETRIC, PETSC_TRUE));
  const PetscMatrix factor = mumps_factor(shifted.get());
  require_mumps(MatMumpsSetIcntl(factor.get(), 24, 1));  // detect null pivots
  require_mumps(MatMumpsSetIcntl(factor.get(), 13,
                                 1));  // the inertia of a ScaLAPACK root node is not reported
  factorise(shifted.get(), factor.get());
  PetscInt negative = 0, zero = 0, positive = 0;
  require_mumps(MatGetInertia(factor.get(), &negative, &zero, &positive));
  if (zero > 0)
    throw Failure({ErrorKind::kSolver, "the count of modes by inertia met " + std::to_string(zero) +
                                           " pivots that are zero"});
  return {static_cast<int>(negative), "mumps"};
}

}  // namespace tremolo
