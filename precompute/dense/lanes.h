// Eight elements side by side: loops over elements work on vectors that the compiler maps to what
// the machine has. For use inside functions marked TREMOLO_CLONES.
#pragma once

#include <cstddef>

#include "common/clones.h"

namespace tremolo {

inline constexpr std::size_t kLanes = 8;
typedef double Lanes __attribute__((vector_size(8 * kLanes)));

// Code for plain x86-64 aligns a vector to 16 bytes, the clones count on 64: what lies in memory
// says so itself.
struct alignas(8 * kLanes) LaneBlock {
  Lanes at;
};

// A displacement gradient of each of eight elements, G(x, d) = at[3*x + d].
struct alignas(8 * kLanes) LaneGradient {
  Lanes at[9];
};

}  // namespace tremolo
