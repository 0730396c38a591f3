// Runs a program's work with MPI, PETSc and SLEPc initialised; errors become messages and exit
// codes, on one rank or several.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "precompute/system/failure.h"

namespace tremolo {

// Calls `work`, in which up to `threads` threads call BLAS at once. Returns the exit code.
int run_session(const char* program, const std::vector<std::string>& petsc_options,
                unsigned threads, const std::function<void()>& work);

// Warns of PETSc options that were never read: a typo is a likely cause of a solver's failure.
void warn_of_unused_options();

// Reports the error and ends all ranks, which would otherwise wait for this one.
[[noreturn]] void stop_all_ranks(const Error& error);

}  // namespace tremolo
