#include "precompute/blas_threads.h"

extern "C" {
void openblas_set_num_threads(int) __attribute__((weak));
int openblas_get_num_threads() __attribute__((weak));
}

namespace tremolo {

BlasThreads::BlasThreads(int threads)
    : before_(openblas_get_num_threads ? openblas_get_num_threads() : 0) {
  if (openblas_set_num_threads) openblas_set_num_threads(threads);
}

BlasThreads::~BlasThreads() {
  if (openblas_set_num_threads && before_ > 0) openblas_set_num_threads(before_);
}

}  // namespace tremolo
