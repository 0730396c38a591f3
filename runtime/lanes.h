// Vectors of eight doubles for the kernels, whatever the machine's own width: one AVX-512 register,
// two of AVX2, four of SSE2 or NEON. A kernel's functions stand in a file of their own, NAME.inc,
// that runtime/every_machine.inc compiles once for each machine; TREMOLO_BEST(f)(...) calls the one
// for this machine.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "runtime/aligned.h"

namespace tremolo {

namespace lanes {

inline constexpr std::size_t kLanes = 8;

constexpr std::size_t padded(std::size_t count) {
  return (count + kLanes - 1) / kLanes * kLanes;
}

}  // namespace lanes

// Row m, eight long: all bits set in the first m lanes, m = 0..8. From memory, since the compiler
// would turn known masks into loads of single lanes.
inline AlignedDoubles lane_masks() {
  AlignedDoubles masks((lanes::kLanes + 1) * lanes::kLanes, 0.0);
  for (std::size_t row = 0; row <= lanes::kLanes; ++row)
    for (std::size_t lane = 0; lane < row; ++lane)
      masks[row * lanes::kLanes + lane] = std::bit_cast<double>(~std::uint64_t{0});
  return masks;
}

// Sanitizers instrument before a program may ask what it runs on: they get the plain version.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(TREMOLO_SANITIZED)
#define TREMOLO_X86_MACHINES 1
enum class Machine { kPlain, kAvx2, kAvx512 };
// The widest that this machine has; TREMOLO_VECTORS=avx2 or =plain in the environment asks for
// less.
inline Machine this_machine() {
  static const Machine machine = [] {
    const char* asked = std::getenv("TREMOLO_VECTORS");
    const std::string_view limit = asked == nullptr ? "" : asked;
    if (limit == "plain" || !__builtin_cpu_supports("x86-64-v3")) return Machine::kPlain;
    if (limit == "avx2" || !__builtin_cpu_supports("x86-64-v4")) return Machine::kAvx2;
    return Machine::kAvx512;
  }();
  return machine;
}
#define TREMOLO_BEST(function)                            \
  (this_machine() == Machine::kAvx512 ? &avx512::function \
   : this_machine() == Machine::kAvx2 ? &avx2::function   \
                                      : &plain::function)
#else
#define TREMOLO_BEST(function) (&plain::function)
#endif

#define TREMOLO_INLINE [[gnu::always_inline]] inline

}  // namespace tremolo
