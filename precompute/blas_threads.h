// How many threads BLAS uses inside one call.
#pragma once

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

}  // namespace tremolo
