// PETSc and SLEPc in C++: checked calls and owning handles. Only few files use their types; linear
// algebra on columns uses Eigen on each rank's own rows.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <slepceps.h>

namespace tremolo {

// Initialises MPI, PETSc and SLEPc for the lifetime of the object. options: flags for PETSc.
// PETSc's signal handlers and error output are disabled; errors become Failures.
class PetscSession {
 public:
  PetscSession(const char* program, const std::vector<std::string>& options);
  PetscSession(const PetscSession&) = delete;
  PetscSession& operator=(const PetscSession&) = delete;
  ~PetscSession();
};

// Throws Failure with PETSc's message if `code` is an error. `doing` completes "PETSc failed to
// ...". kSystem if memory ran out, else kSolver.
void check_petsc(PetscErrorCode code, const char* doing);

// Checks the package's status, since PETSc reports success if a package fails to factorise. Throws
// Failure: kSystem if memory ran out, else kSolver.
void require_factorised(Mat factor);

// Returns options that were given but never read: usually a typo or a missing prefix.
std::vector<std::string> unused_petsc_options();

// Returns the options given, on one line; empty if there are none.
std::string petsc_options();

// Returns "major.minor.subminor".
std::string version_text(int major, int minor, int subminor);

// Versions of the loaded libraries, which may be later than those compiled against.
std::string petsc_version();
std::string slepc_version();

int mpi_rank();
int mpi_ranks();

// Reduce one value over all ranks; collective, the same result on all ranks.
double over_ranks(double value, MPI_Op operation);
int over_ranks(int value, MPI_Op operation);
bool true_on_all_ranks(bool here);

// Returns whether a handle must not be destroyed: destruction is collective (MUMPS communicates),
// and an exception on this rank means that the others are elsewhere. The program is about to end.
bool left_behind(void* handle) noexcept;

// An owning handle.
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

// A set of distributed vectors: this rank's rows (local dofs) of each, column-major.
using Columns = Eigen::MatrixXd;

// Returns a distributed dense matrix that shares the memory of `columns` and must not outlive it.
PetscMatrix as_dense(const Columns& columns);

// Returns one distributed vector a column, sharing the memory of `columns`.
std::vector<PetscVector> as_vectors(const Columns& columns);

// Returns one distributed vector a column, with copies of the values.
std::vector<PetscVector> copied_vectors(const Columns& columns);

std::vector<Vec> handles_of(const std::vector<PetscVector>& vectors);

// Returns A X for a sparse A.
Columns multiply(Mat a, const Columns& x);

// Returns X^T Y over all ranks.
Eigen::MatrixXd inner_products(const Columns& x, const Columns& y);

// Sums a matrix over all ranks, in place; bitwise the same result on all ranks.
void sum_over_ranks(Eigen::MatrixXd& matrix);

}  // namespace tremolo
