// Debian 12's OpenBLAS (0.3.21) takes processors that are younger than it for the oldest: its dense
// products then take four times as long as they need to (measured on an Emerald Rapids).
#pragma once

#include <string_view>

namespace tremolo {

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
