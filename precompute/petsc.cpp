#include "precompute/petsc.h"

#include <cstdlib>

#include "precompute/failure.h"

namespace tremolo {
namespace {

std::string last_message;

// Keeps the innermost message instead of printing a traceback.
PetscErrorCode keep_message(MPI_Comm, int, const char*, const char*, PetscErrorCode code,
                            PetscErrorType type, const char* message, void*) {
  if (type == PETSC_ERROR_INITIAL && message != nullptr) last_message = message;
  return code;
}

void require(PetscErrorCode code, const char* doing) {
  check_petsc(code, doing);
}

// A process that no launcher started talks to itself only. Open MPI would start a daemon for it and
// probe every network first: 0.35 s. Its folder under TMPDIR, which nothing would use, is shared by
// all such processes: one that ends removes it under the feet of one that starts. What the user set
// stays; other MPIs do not read these.
void start_alone() {
  for (const char* launched : {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMIX_NAMESPACE", "PMI_RANK"})
    if (std::getenv(launched) != nullptr) return;
  constexpr int kKeep = 0;
  ::setenv("OMPI_MCA_ess_singleton_isolated", "1", kKeep);
  ::setenv("OMPI_MCA_orte_create_session_dirs", "0", kKeep);
  ::setenv("OMPI_MCA_btl", "self", kKeep);
  ::setenv("OMPI_MCA_pml", "ob1", kKeep);
}

}  // namespace

PetscSession::PetscSession(const char* program, const std::vector<std::string>& options) {
  std::vector<std::string> words{program};
  words.insert(words.end(), options.begin(), options.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  int count = static_cast<int>(words.size());
  char** arguments = pointers.data();
  // A user's ~/.petscrc or environment must not change what the same command gives.
  PetscOptionsSetValue(nullptr, "-skip_petscrc", nullptr);
  // Signals stay with who installed a handler: an unfinished file is removed on SIGTERM.
  PetscOptionsSetValue(nullptr, "-no_signal_handler", nullptr);
  ::unsetenv("PETSC_OPTIONS");
  start_alone();
  if (SlepcInitialize(&count, &arguments, nullptr, nullptr) != 0)
    throw Failure(system_error("PETSc or MPI could not be started"));
  PetscPushErrorHandler(keep_message, nullptr);
  PetscOptionsClearValue(nullptr, "-skip_petscrc");
  PetscOptionsClearValue(nullptr, "-no_signal_handler");
}

PetscSession::~PetscSession() {
  SlepcFinalize();
}

void check_petsc(PetscErrorCode code, const char* doing) {
  if (code == 0) return;
  const ErrorKind kind = code == PETSC_ERR_MEM ? ErrorKind::kSystem : ErrorKind::kSolver;
  throw Failure(
      {kind, std::string("PETSc failed to ") + doing + ": " +
                 (last_message.empty() ? "error " + std::to_string(code) : last_message)});
}

std::vector<std::string> unused_petsc_options() {
  PetscInt count = 0;
  char** names = nullptr;
  char** values = nullptr;
  require(PetscOptionsLeftGet(nullptr, &count, &names, &values), "list its options");
  std::vector<std::string> unused;
  for (PetscInt i = 0; i < count; ++i) unused.emplace_back(std::string("-") + names[i]);
  require(PetscOptionsLeftRestore(nullptr, &count, &names, &values), "list its options");
  return unused;
}

int mpi_rank() {
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  return rank;
}

int mpi_ranks() {
  int ranks = 1;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  return ranks;
}

PetscMatrix as_dense(const Columns& columns) {
  PetscMatrix dense;
  require(MatCreateDense(PETSC_COMM_WORLD, static_cast<PetscInt>(columns.rows()), PETSC_DECIDE,
                         PETSC_DETERMINE, static_cast<PetscInt>(columns.cols()),
                         const_cast<double*>(columns.data()), dense.out()),
          "make a dense matrix");
  return dense;
}

Columns multiply(Mat a, const Columns& x) {
  const PetscMatrix dense = as_dense(x);
  PetscMatrix product;
  require(MatMatMult(a, dense.get(), MAT_INITIAL_MATRIX, PETSC_DEFAULT, product.out()),
          "multiply matrices");
  const double* values = nullptr;
  PetscInt stride = 0;
  require(MatDenseGetLDA(product.get(), &stride), "read a product");
  require(MatDenseGetArrayRead(product.get(), &values), "read a product");
  Columns result = Eigen::Map<const Columns, 0, Eigen::OuterStride<>>(values, x.rows(), x.cols(),
                                                                      Eigen::OuterStride<>(stride));
  require(MatDenseRestoreArrayRead(product.get(), &values), "read a product");
  return result;
}

void sum_over_ranks(Eigen::MatrixXd& matrix) {
  if (mpi_ranks() == 1) return;
  MPI_Allreduce(MPI_IN_PLACE, matrix.data(), static_cast<int>(matrix.size()), MPI_DOUBLE, MPI_SUM,
                PETSC_COMM_WORLD);
}

Eigen::MatrixXd inner_products(const Columns& x, const Columns& y) {
  Eigen::MatrixXd products = x.transpose() * y;
  sum_over_ranks(products);
  return products;
}

}  // namespace tremolo
