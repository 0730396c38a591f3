// Vectors of eight doubles for the kernels, whatever the machine's own width: one AVX-512 register,
// two of AVX2, four of SSE2 or NEON. A kernel's functions stand in a file of their own, NAME.inc,
// that runtime/kernels/every_machine.inc compiles once for each machine; (*TREMOLO_BEST(f))(...)
// calls the one for this machine.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "runtime/kernels/aligned.h"
#include "runtime/kernels/machine.h"

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

#define TREMOLO_INLINE [[gnu::always_inline]] inline

}  // namespace tremolo
