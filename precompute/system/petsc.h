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

// PETSc does not fail where the package that factorises does. Throws Failure: kSystem when memory
// ran out, else kSolver.
void require_factorised(Mat factor);

// Options given that nothing asked for: usually a typo or a missing prefix.
std::vector<std::string> unused_petsc_options();

// Those given, as one line; empty: none.
std::string petsc_options();

// "major.minor.subminor"
std::string version_text(int major, int minor, int subminor);

// Of the libraries that are loaded, which may be later than those compiled against.
std::string petsc_version();
std::string slepc_version();

int mpi_rank();
int mpi_ranks();

// One value over all ranks, which call it together and all get the result.
double over_ranks(double value, MPI_Op operation);
int over_ranks(int value, MPI_Op operation);
bool true_on_all_ranks(bool here);

// Whether a handle must be left alone: to destroy it takes all ranks (MUMPS talks to the others),
// and an exception of this one has left them elsewhere. The program is about to end.
bool left_behind(void* handle) noexcept;

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
    if (handle_ != nullptr && !left_behind(handle_)) Destroy(&handle_);
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

// The same memory as one distributed vector a column.
std::vector<PetscVector> as_vectors(const Columns& columns);

// The same with memory of their own.
std::vector<PetscVector> copied_vectors(const Columns& columns);

std::vector<Vec> handles_of(const std::vector<PetscVector>& vectors);

// A X for a sparse A.
Columns multiply(Mat a, const Columns& x);

// X^T Y over all ranks.
Eigen::MatrixXd inner_products(const Columns& x, const Columns& y);

// Sum of a matrix over all ranks, in place; the same bits everywhere.
void sum_over_ranks(Eigen::MatrixXd& matrix);

}  // namespace tremolo
