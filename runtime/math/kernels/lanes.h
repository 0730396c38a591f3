// Vectors of eight doubles for the kernels, arrays for them, and the instruction sets that they are
// compiled for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <string_view>
#include <vector>

namespace tremolo {

// Arrays that begin at a cache line, so that no vector load crosses two.
inline constexpr std::size_t kCacheLine = 64;  // bytes

template <class T>
struct CacheLineAllocator {
  using value_type = T;
  CacheLineAllocator() = default;
  template <class Other>
  CacheLineAllocator(const CacheLineAllocator<Other>&) {}  // NOLINT: an allocator converts
  T* allocate(std::size_t count) {
    return static_cast<T*>(::operator new (count * sizeof(T), std::align_val_t{kCacheLine}));
  }
  void deallocate(T* first, std::size_t) {
    ::operator delete (first, std::align_val_t{kCacheLine});
  }
  bool operator==(const CacheLineAllocator&) const { return true; }
};

using AlignedDoubles = std::vector<double, CacheLineAllocator<double>>;
using AlignedFloats = std::vector<float, CacheLineAllocator<float>>;

// The instruction set of the kernels in use: AVX-512, AVX2, or the one of every machine.
//
// The functions of a kernel are in a file NAME.inc. NAME.cpp defines the structs that they take,
// then TREMOLO_KERNEL as the path of that file, and includes every_instruction_set.inc: this
// compiles the functions once in each of the namespaces avx512, avx2 and plain. TREMOLO_CALL(f, x)
// calls f(x) for this processor, TREMOLO_CALL_FOR(set, f, x) that of a set.
//
// Structs are passed by reference and copied by the function. On the stack the caller would write a
// copy in pieces that the processor cannot read back as a whole for a dozen clocks; behind a
// reference a vector that is stored could change a pointer, and each use would load it again.

enum class InstructionSet { kPlain, kAvx2, kAvx512 };

// A sanitizer instruments the code that detects the processor, which must not run so early: its
// builds have the plain kernels alone.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(TREMOLO_SANITIZED)
#define TREMOLO_X86_KERNELS 1
// The largest set that the processor has; TREMOLO_VECTORS=avx2 or =plain in the environment selects
// a smaller one.
inline InstructionSet instruction_set() {
  static const InstructionSet chosen = [] {
    const char* asked = std::getenv("TREMOLO_VECTORS");
    const std::string_view limit = asked == nullptr ? "" : asked;
    if (limit == "plain" || !__builtin_cpu_supports("x86-64-v3")) return InstructionSet::kPlain;
    if (limit == "avx2" || !__builtin_cpu_supports("x86-64-v4")) return InstructionSet::kAvx2;
    return InstructionSet::kAvx512;
  }();
  return chosen;
}
#define TREMOLO_CALL_FOR(set, function, ...)              \
  (*((set) == InstructionSet::kAvx512 ? &avx512::function \
     : (set) == InstructionSet::kAvx2 ? &avx2::function   \
                                      : &plain::function))(__VA_ARGS__)
#else
inline InstructionSet instruction_set() {
  return InstructionSet::kPlain;
}
#define TREMOLO_CALL_FOR(set, function, ...) (static_cast<void>(set), plain::function(__VA_ARGS__))
#endif

#define TREMOLO_CALL(function, ...) TREMOLO_CALL_FOR(instruction_set(), function, __VA_ARGS__)

}  // namespace tremolo

// Vectors of eight doubles for the kernels, on any registers: one of AVX-512, two of AVX2, four of
// SSE2 or NEON. lanes.inc has the operations. In WebAssembly a vector is one register: its
// compilers have sixteen, and longer vectors double the code and are slower.

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
