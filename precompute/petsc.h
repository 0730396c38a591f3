// PETSc and SLEPc as C++ values: checked calls and owned handles. One of the few files with their
// types; linear algebra on columns is done with Eigen on each rank's own rows.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <slepceps.h>

namespace tremolo {

// Initialises MPI, PETSc and SLEPc for the life of the object. `options` are PETSc's own flags.
// PETSc's signal handlers and its printing of errors are switched off: errors become Failures.
class PetscSession {
 public:
  PetscSession(const char* program, const std::vector<std::string>& options);
  PetscSession(const PetscSession&) = delete;
  PetscSession& operator=(const PetscSession&) = delete;
  ~PetscSession();
};

// Throws Failure with PETSc's own message. `doing` completes "PETSc failed to ...". kSystem when
// memory ran out, else kSolver.
void check_petsc(PetscErrorCode code, const char* doing);

// Options given that nothing asked for: usually a typo or a missing prefix.
std::vector<std::string> unused_petsc_options();

int mpi_rank();
int mpi_ranks();

// A handle that destroys itself.
template <class Handle, PetscErrorCode (*Destroy)(Handle*)>
class PetscHandle {
 public:
  PetscHandle() = default;
  PetscHandle(PetscHandle&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  PetscHandle& operator=(PetscHandle&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~PetscHandle() {
    if (handle_ != nullptr) Destroy(&handle_);
  }
  Handle get() const { return handle_; }
  Handle* out() { return &handle_; }

 private:
  Handle handle_ = nullptr;
};
using PetscMatrix = PetscHandle<Mat, MatDestroy>;
using PetscVector = PetscHandle<Vec, VecDestroy>;
using PetscEigenSolver = PetscHandle<EPS, EPSDestroy>;

// Several vectors side by side: this rank's rows (local dofs) of each, column-major.
using Columns = Eigen::MatrixXd;

// The same memory as a distributed dense matrix; it must not outlive `columns`.
PetscMatrix as_dense(const Columns& columns);

// A X for a sparse A.
Columns multiply(Mat a, const Columns& x);

// X^T Y over all ranks.
Eigen::MatrixXd inner_products(const Columns& x, const Columns& y);

// Sum of a matrix over all ranks, in place.
void sum_over_ranks(Eigen::MatrixXd& matrix);

}  // namespace tremolo
