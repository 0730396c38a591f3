// The processor's instruction sets and this program's processor time.
#pragma once

#include <ctime>
#include <string_view>

// One binary for every x86-64: the loader picks the widest vectors the machine has. Sanitizers
// instrument before the resolver may run, so they get the plain version.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(TREMOLO_SANITIZED)
#define TREMOLO_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define TREMOLO_CLONES
#endif

namespace tremolo {

// The largest number of threads that may be requested: no machine can use more, and a refusal by
// the system takes seconds.
inline constexpr unsigned kMostThreads = 1024;

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

// Debian 12's OpenBLAS (0.3.21) takes processors that are younger than it for the oldest: its dense
// products then take four times as long as they need to (measured on an Emerald Rapids).

// A core that OpenBLAS knows (a value of OPENBLAS_CORETYPE) and this processor can do; nullptr when
// the one it has `detected` is no worse.
inline const char* better_blas_core(std::string_view detected) {
#if defined(__x86_64__)
  for (const std::string_view old : {"Prescott", "Core2", "Nehalem", "Sandybridge", "Barcelona"}) {
    if (detected != old) continue;
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl"))
      return "SkylakeX";
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return "Haswell";
  }
#endif
  return nullptr;
}

}  // namespace tremolo
