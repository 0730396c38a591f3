#include "precompute/ranks/session.h"

#include <chrono>
#include <cstdio>
#include <thread>

#include "common/text.h"
#include "precompute/ranks/rank_agreement.h"
#include "precompute/system/blas_room.h"
#include "precompute/system/petsc.h"
#include "precompute/system/term_signal.h"

namespace tremolo {
namespace {

int report(const Error& error) {
  std::fprintf(stderr, "tremolo-precompute: %s\n", printable(error.message).c_str());
  return exit_code(error);
}

// Handles an error that may have occurred on this rank only, and returns the exit code.
int end_alone(const Error& error) {
  // Errors of the input are the same on all ranks, and one reports them. Other errors may be those
  // of one rank, and the rest would wait for it for ever.
  const bool common = error.kind == ErrorKind::kContent || error.kind == ErrorKind::kUsage;
  const bool alone = mpi_ranks() == 1 || (!common && !all_ranks_failed());
  if (alone || mpi_rank() == 0) {
    report(error);
    if (error.kind == ErrorKind::kSolver) warn_of_unused_options();
  } else if (!common) {
    std::this_thread::sleep_for(std::chrono::seconds(5));  // rank 0 reports and ends all
  }
  if (!common && mpi_ranks() > 1) MPI_Abort(PETSC_COMM_WORLD, exit_code(error));
  return exit_code(error);
}

}  // namespace

void warn_of_unused_options() {
  for (const std::string& option : unused_petsc_options())
    std::fprintf(stderr, "  warning: no solver asked for the PETSc option %s (a typo?)\n",
                 option.c_str());
}

void stop_all_ranks(const Error& error) {
  report(error);
  MPI_Abort(PETSC_COMM_WORLD, exit_code(error));
  std::abort();
}

int run_session(const char* program, const std::vector<std::string>& petsc_options,
                unsigned threads, const std::function<void()>& work) {
  try {
    take_room_for_blas(threads);
    const PetscSession session(program, petsc_options);
    take_term_signal();
    try {
      work();
      return 0;
    } catch (const SharedFailure& failure) {
      return mpi_rank() == 0 ? report(failure.error()) : exit_code(failure.error());
    } catch (...) {
      return end_alone(current_error());
    }
  } catch (...) {
    return report(current_error());
  }
}

}  // namespace tremolo
