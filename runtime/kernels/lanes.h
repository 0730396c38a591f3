// Vectors of eight doubles for the kernels, on any registers: one of AVX-512, two of AVX2, four of
// SSE2 or NEON. lanes.inc has the operations. In WebAssembly a vector is one register: its
// compilers have sixteen, and longer vectors double the code and are slower.
#pragma once

#include <cstddef>
#include <cstdint>

#include "runtime/kernels/aligned.h"
#include "runtime/kernels/instruction_set.h"

#define TREMOLO_INLINE [[gnu::always_inline]] inline

namespace tremolo {

#if defined(__wasm__)
inline constexpr std::size_t kVectorLanes = 2;
#else
inline constexpr std::size_t kVectorLanes = 8;
#endif

// The next multiple of a vector's length.
constexpr std::size_t padded(std::size_t count) {
  return (count + kVectorLanes - 1) / kVectorLanes * kVectorLanes;
}

// Row m has all bits set in its first m lanes. The table is defined in lanes.cpp and hidden from
// the compiler, which converts masks that it knows into loads of single lanes.
struct alignas(kCacheLine) LaneMasks {
  double row[kVectorLanes + 1][kVectorLanes];
};
extern const LaneMasks kLaneMasks;

}  // namespace tremolo
