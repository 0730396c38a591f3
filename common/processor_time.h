// A clock for timing.
#pragma once

#include <ctime>

namespace tremolo {

// The processor time of this thread, s; time taken by other threads and programs is not counted.
inline double processor_time() {
  std::timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace tremolo
