#include "precompute/system/blas_threads.h"

#include <cstdlib>
#include <unistd.h>

#include "common/processor.h"

extern "C" {
void openblas_set_num_threads(int) __attribute__((weak));
int openblas_get_num_threads() __attribute__((weak));
char* openblas_get_config() __attribute__((weak));
char* openblas_get_corename() __attribute__((weak));
}

namespace tremolo {

BlasThreads::BlasThreads(int threads) : before_(blas_thread_count()) {
  if (openblas_set_num_threads && threads > 0) openblas_set_num_threads(threads);
}

BlasThreads::~BlasThreads() {
  if (openblas_set_num_threads && before_ > 0) openblas_set_num_threads(before_);
}

int blas_thread_count() {
  return openblas_get_num_threads ? openblas_get_num_threads() : 0;
}

void use_fast_blas_kernels(char** words) {
  constexpr const char* kVariable = "OPENBLAS_CORETYPE";
  if (openblas_get_corename == nullptr || std::getenv(kVariable) != nullptr) return;
  const char* core = better_blas_core(openblas_get_corename());
  if (core == nullptr) return;
  ::setenv(kVariable, core, 1);
  ::execv("/proc/self/exe", words);
  ::unsetenv(kVariable);  // execv failed: go on with slower kernels
}

std::string blas_name() {
  return openblas_get_config ? openblas_get_config() : "unknown";
}

}  // namespace tremolo
