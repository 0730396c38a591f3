// Which BLAS there is, and how many threads it uses inside one call.
#pragma once

#include <string>

namespace tremolo {

// While this lives, BLAS uses `threads` threads; afterwards as many as before. Only OpenBLAS
// listens; another BLAS goes on as its environment says.
class BlasThreads {
 public:
  explicit BlasThreads(int threads);
  BlasThreads(const BlasThreads&) = delete;
  BlasThreads& operator=(const BlasThreads&) = delete;
  ~BlasThreads();

 private:
  int before_;
};

// Starts the program anew where OpenBLAS, which chooses its kernels while it is loaded, has not
// recognised the processor (common/blas_core.h), with OPENBLAS_CORETYPE set; does not return then.
// To be called first. What the user has set stays.
void use_fast_blas_kernels(char** words);

// How many threads BLAS uses inside one call; 0 where it does not say.
int blas_thread_count();

// "OpenBLAS 0.3.21 ... SkylakeX": version, and the kernels of this machine, whose last digits are
// their own. "unknown" of another BLAS.
std::string blas_name();

}  // namespace tremolo
