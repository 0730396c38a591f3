// A clock for timing.
#pragma once

#include <ctime>

namespace tremolo {

// Returns the time of a system clock, s.
inline double clock_seconds(clockid_t clock) {
  std::timespec time{};
  ::clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// The processor time of this thread, s; time taken by other threads and programs is not counted.
inline double processor_time() {
  return clock_seconds(CLOCK_THREAD_CPUTIME_ID);
}

}  // namespace tremolo
