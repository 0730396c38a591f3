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
#pragma once

#include <cstdlib>
#include <string_view>

namespace tremolo {

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
