// SIMD over eight elements: the compiler maps the vector type to the machine's instructions. For
// use in functions marked TREMOLO_CLONES.
#pragma once

#include <cstddef>

#include "common/processor.h"

namespace tremolo {

inline constexpr std::size_t kLanes = 8;
typedef double Lanes __attribute__((vector_size(8 * kLanes)));

// The alignment is explicit, since code compiled for plain x86-64 aligns a vector to 16 bytes while
// the clones assume 64.
struct alignas(8 * kLanes) LaneBlock {
  Lanes at;
};

// Displacement gradients of eight elements, G(x, d) = at[3*x + d].
struct alignas(8 * kLanes) LaneGradient {
  Lanes at[9];
};

}  // namespace tremolo
