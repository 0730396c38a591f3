// K - sigma M by CHOLMOD's factor in one process, with our own triangular solves.
#include <algorithm>

#include "precompute/solver/shifted_solver.h"
#include "precompute/solver/sparse_cholesky.h"

namespace tremolo {
namespace {

class CholmodSolver final : public ShiftedSolver {
 public:
  explicit CholmodSolver(const Pencil& pencil) : pencil_(pencil) {}

  void solve(const ColumnsRef& b, ColumnsOut x) const override {
    SparseCholesky::Workspace workspace;
    factor_->solve(b, x, workspace);
  }
  bool threads_may_share() const override { return true; }

  InertiaCount count_negative(double sigma, double bound, double most_growth) override {
    // A pivot that is small by chance, since an eigenvalue of a submatrix lies near the bound,
    // causes far less growth than this.
    constexpr double kStable = 1e5;
    prepare(sigma);
    const PetscMatrix shifted = shifted_stiffness(pencil_.matrices, bound);
    const LdlReport report = factor_->count_negative(sparse_rows(shifted.get()), pencil_.threads);
    release();
    if (report.growth <= std::min(kStable, most_growth))
      return {static_cast<int>(report.negative), "own"};
    return count_negative_by_mumps(pencil_.matrices, bound);
  }

  std::string package() const override { return "cholmod"; }
  double flops() const override { return flops_; }
  double entries() const override { return entries_; }

 private:
  void factorise(double sigma) override {
    const PetscMatrix shifted =
        sigma == 0.0 ? PetscMatrix() : shifted_stiffness(pencil_.matrices, sigma);
    Mat matrix = sigma == 0.0 ? pencil_.stiffness() : shifted.get();
    factor_ = std::make_unique<SparseCholesky>(sparse_rows(matrix));
    flops_ = factor_->flops();
    entries_ = static_cast<double>(factor_->entries());
  }
  void free_factor() override { factor_.reset(); }

  const Pencil& pencil_;
  std::unique_ptr<SparseCholesky> factor_;
  double flops_ = 0, entries_ = 0;
};

}  // namespace

std::unique_ptr<ShiftedSolver> make_cholmod_solver(const Pencil& pencil) {
  return std::make_unique<CholmodSolver>(pencil);
}

}  // namespace tremolo
