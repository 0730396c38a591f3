// A program's work with MPI, PETSc and SLEPc running: errors become messages and exit codes, on one
// rank or several.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "precompute/system/failure.h"

namespace tremolo {

// Calls `work`, whose BLAS is called by so many threads at once. Returns the exit code.
int run_session(const char* program, const std::vector<std::string>& petsc_options,
                unsigned threads, const std::function<void()>& work);

// A typo in one of PETSc's options is a likely cause when a solver gives up.
void warn_of_unused_options();

// Tells the error and ends all ranks: one that failed alone would leave the others waiting.
[[noreturn]] void stop_all_ranks(const Error& error);

}  // namespace tremolo
