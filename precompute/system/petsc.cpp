#include "precompute/system/petsc.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <exception>
#include <string_view>

#include "precompute/system/failure.h"

namespace tremolo {
namespace {

std::string last_message;

// Keeps PETSc's innermost message instead of printing a traceback, and returns the code that its
// callers hand on. PETSc 3.18 reports an aligned allocation that failed with the line of its caller
// as the code and the caller's name as the message.
PetscErrorCode keep_message(MPI_Comm, int, const char* function, const char*, PetscErrorCode code,
                            PetscErrorType type, const char* message, void*) {
  if (function != nullptr && std::string_view(function) == "PetscMallocAlign") code = PETSC_ERR_MEM;
  if (type == PETSC_ERROR_INITIAL && message != nullptr) last_message = message;
  if (code == PETSC_ERR_MEM) last_message = "out of memory";
  return code;
}

void require(PetscErrorCode code, const char* doing) {
  check_petsc(code, doing);
}

// Isolates a process that was not started by an MPI launcher. Otherwise Open MPI would start a
// daemon and probe all networks (0.35 s), and would use a session folder under TMPDIR that all such
// processes share: one that ends could remove it while another starts. Variables set by the user
// are kept; other MPIs ignore these.
void start_alone() {
  for (const char* launched : {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMIX_NAMESPACE", "PMI_RANK"})
    if (std::getenv(launched) != nullptr) return;
  constexpr int kKeep = 0;
  ::setenv("OMPI_MCA_ess_singleton_isolated", "1", kKeep);
  ::setenv("OMPI_MCA_orte_create_session_dirs", "0", kKeep);
  ::setenv("OMPI_MCA_btl", "self", kKeep);
  ::setenv("OMPI_MCA_pml", "ob1", kKeep);
}

// Ranks that wait for each other yield the processor. By default they poll for messages: with three
// ranks on two processors an iterative solve then took 146 s instead of 3. If each rank has a
// processor the cost is not measurable (7.0 s in both cases). A user's setting is kept.
void yield_while_waiting() {
  constexpr int kKeep = 0;
  ::setenv("OMPI_MCA_mpi_yield_when_idle", "1", kKeep);
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
  // A user's ~/.petscrc or environment must not change the results of a command.
  PetscOptionsSetValue(nullptr, "-skip_petscrc", nullptr);
  // Signals must reach our handlers: one removes an unfinished file on SIGTERM.
  PetscOptionsSetValue(nullptr, "-no_signal_handler", nullptr);
  ::unsetenv("PETSC_OPTIONS");
  start_alone();
  yield_while_waiting();
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

void require_factorised(Mat factor) {
  MatFactorError error = MAT_FACTOR_NOERROR;
  require(MatFactorGetError(factor, &error), "ask for the factor");
  if (error == MAT_FACTOR_NOERROR) return;
  MatSolverType package = nullptr;
  require(MatFactorGetSolverType(factor, &package), "ask for the factor");
  const std::string who = package == nullptr ? "PETSc" : package;
  std::string codes;
  bool memory = error == MAT_FACTOR_OUTMEMORY;
  if (who == MATSOLVERMUMPS) {
    // Codes for failed allocations and too small workspaces, in analysis and factorisation.
    constexpr std::array<PetscInt, 8> kMemory = {-7, -8, -9, -11, -13, -17, -19, -20};
    PetscInt code = 0, detail = 0;
    require(MatMumpsGetInfog(factor, 1, &code), "ask for the factor");
    require(MatMumpsGetInfog(factor, 2, &detail), "ask for the factor");
    memory = memory || std::find(kMemory.begin(), kMemory.end(), code) != kMemory.end();
    codes = ", INFOG(1) = " + std::to_string(code) + ", INFOG(2) = " + std::to_string(detail);
  }
  if (memory)
    throw Failure(system_error("out of memory for the factor of the stiffness (" + who + codes +
                               "): --solver iterative makes none"));
  throw Failure(
      {ErrorKind::kSolver, "the stiffness could not be factorised (" + who + codes + ")"});
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

std::string petsc_options() {
  char* given = nullptr;
  require(PetscOptionsGetAll(nullptr, &given), "list its options");
  std::string text = given == nullptr ? "" : given;
  require(PetscFree(given), "list its options");
  while (text.ends_with(' ')) text.pop_back();
  return text;
}

std::string version_text(int major, int minor, int subminor) {
  return std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(subminor);
}

std::string petsc_version() {
  PetscInt major = 0, minor = 0, subminor = 0;
  require(PetscGetVersionNumber(&major, &minor, &subminor, nullptr), "tell its version");
  return version_text(major, minor, subminor);
}

std::string slepc_version() {
  PetscInt major = 0, minor = 0, subminor = 0;
  require(SlepcGetVersionNumber(&major, &minor, &subminor, nullptr), "tell its version");
  return version_text(major, minor, subminor);
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

double over_ranks(double value, MPI_Op operation) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, operation, PETSC_COMM_WORLD);
  return value;
}

int over_ranks(int value, MPI_Op operation) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_INT, operation, PETSC_COMM_WORLD);
  return value;
}

bool true_on_all_ranks(bool here) {
  return over_ranks(here ? 1 : 0, MPI_MIN) == 1;
}

bool left_behind(void* handle) noexcept {
  if (std::uncaught_exceptions() == 0 || mpi_ranks() == 1) return false;
  // The handles stay reachable, so that leak detection does not report them.
  static std::array<void*, 64> handles{};
  static std::size_t count = 0;
  if (count < handles.size()) handles[count++] = handle;
  return true;
}

PetscMatrix as_dense(const Columns& columns) {
  PetscMatrix dense;
  require(MatCreateDense(PETSC_COMM_WORLD, static_cast<PetscInt>(columns.rows()), PETSC_DECIDE,
                         PETSC_DETERMINE, static_cast<PetscInt>(columns.cols()),
                         const_cast<double*>(columns.data()), dense.out()),
          "make a dense matrix");
  return dense;
}

std::vector<PetscVector> as_vectors(const Columns& columns) {
  std::vector<PetscVector> vectors(columns.cols());
  for (Eigen::Index c = 0; c < columns.cols(); ++c)
    require(VecCreateMPIWithArray(PETSC_COMM_WORLD, 1, static_cast<PetscInt>(columns.rows()),
                                  PETSC_DETERMINE, columns.col(c).data(), vectors[c].out()),
            "make a vector");
  return vectors;
}

std::vector<PetscVector> copied_vectors(const Columns& columns) {
  const std::vector<PetscVector> vectors = as_vectors(columns);
  std::vector<PetscVector> copies(vectors.size());
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    require(VecDuplicate(vectors[i].get(), copies[i].out()), "copy a vector");
    require(VecCopy(vectors[i].get(), copies[i].get()), "copy a vector");
  }
  return copies;
}

std::vector<Vec> handles_of(const std::vector<PetscVector>& vectors) {
  std::vector<Vec> handles;
  for (const PetscVector& vector : vectors) handles.push_back(vector.get());
  return handles;
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
  // MPI_Allreduce may round differently on each rank, and decisions based on the sum must agree.
  const auto size = static_cast<int>(matrix.size());
  if (mpi_rank() == 0)
    MPI_Reduce(MPI_IN_PLACE, matrix.data(), size, MPI_DOUBLE, MPI_SUM, 0, PETSC_COMM_WORLD);
  else
    MPI_Reduce(matrix.data(), nullptr, size, MPI_DOUBLE, MPI_SUM, 0, PETSC_COMM_WORLD);
  MPI_Bcast(matrix.data(), size, MPI_DOUBLE, 0, PETSC_COMM_WORLD);
}

Eigen::MatrixXd inner_products(const Columns& x, const Columns& y) {
  Eigen::MatrixXd products = x.transpose() * y;
  sum_over_ranks(products);
  return products;
}

}  // namespace tremolo
