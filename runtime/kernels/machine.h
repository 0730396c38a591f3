// What the machine that the program runs on can do with vectors. Kernels stand in files NAME.inc
// that runtime/kernels/every_machine.inc compiles once for each; (*TREMOLO_BEST(f))(...) calls the
// one for this machine.
#pragma once

#include <cstdlib>
#include <string_view>

namespace tremolo {

enum class Machine { kPlain, kAvx2, kAvx512 };

// Sanitizers instrument before a program may ask what it runs on: they get the plain version.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(TREMOLO_SANITIZED)
#define TREMOLO_X86_MACHINES 1
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
inline Machine this_machine() {
  return Machine::kPlain;
}
#define TREMOLO_BEST(function) (&plain::function)
#endif

}  // namespace tremolo
