// Queries of the BLAS library, and control of its number of threads.
#pragma once

#include <string>

namespace tremolo {

// Sets the number of BLAS threads for its lifetime, then restores it. It affects OpenBLAS only;
// other libraries follow their environment variables.
class BlasThreads {
 public:
  explicit BlasThreads(int threads);
  BlasThreads(const BlasThreads&) = delete;
  BlasThreads& operator=(const BlasThreads&) = delete;
  ~BlasThreads();

 private:
  int before_;
};

// Restarts the program with OPENBLAS_CORETYPE set if OpenBLAS, which selects its kernels when
// loaded, has not recognised the processor (common/processor.h); does not return then. Must be
// called first. A value set by the user is kept.
void use_fast_blas_kernels(char** words);

// Returns the number of threads of one BLAS call; 0 if unknown.
int blas_thread_count();

// Returns for instance "OpenBLAS 0.3.21 ... SkylakeX": the version and the kernels, on which
// rounding depends; "unknown" for other libraries.
std::string blas_name();

}  // namespace tremolo
