// Vectors of eight doubles that the compiler maps to whatever the machine has (one AVX-512
// register, two of AVX2, four of SSE2 or NEON). Use them inside functions marked TREMOLO_CLONES;
// the helpers are inlined there and so compiled for each machine.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tremolo::lanes {

inline constexpr std::size_t kLanes = 8;

typedef double Vector __attribute__((vector_size(64), may_alias));             // aligned
typedef double Loose __attribute__((vector_size(64), aligned(8), may_alias));  // anywhere
typedef std::int64_t Mask __attribute__((vector_size(64), may_alias));

#define TREMOLO_INLINE [[gnu::always_inline]] inline

constexpr std::size_t padded(std::size_t count) {
  return (count + kLanes - 1) / kLanes * kLanes;
}

TREMOLO_INLINE Vector load(const double* at) {
  return *reinterpret_cast<const Vector*>(at);
}
// Into a register once. What is loaded plainly and used several times the compiler may load several
// times, as a memory operand of each use; loads are what the kernels are short of.
TREMOLO_INLINE Vector load_once(const double* at) {
  return *reinterpret_cast<const volatile Vector*>(at);
}
TREMOLO_INLINE Vector load_loose(const double* at) {
  return *reinterpret_cast<const Loose*>(at);
}
TREMOLO_INLINE Vector load_loose_once(const double* at) {
  return *reinterpret_cast<const volatile Loose*>(at);
}
TREMOLO_INLINE void store(double* at, Vector v) {
  *reinterpret_cast<Vector*>(at) = v;
}
TREMOLO_INLINE void store_loose(double* at, Vector v) {
  *reinterpret_cast<Loose*>(at) = v;
}
TREMOLO_INLINE Vector all(double value) {
  // An initialiser list would be set lane by lane in functions with several clones.
  const Vector first = {value};
  return __builtin_shufflevector(first, first, 0, 0, 0, 0, 0, 0, 0, 0);
}

// Bit by bit.
TREMOLO_INLINE Vector both(Vector v, Vector mask) {
  return (Vector)((Mask)v & (Mask)mask);
}

TREMOLO_INLINE double sum(Vector v) {
  const double a = (v[0] + v[4]) + (v[2] + v[6]);
  const double b = (v[1] + v[5]) + (v[3] + v[7]);
  return a + b;
}

// Lanes [a, b, a, b, ...] of partial sums: two vectors folded into one.
TREMOLO_INLINE Vector fold(Vector a, Vector b) {
  return __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14) +
         __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
}
TREMOLO_INLINE Vector fold_pairs(Vector a, Vector b) {
  return __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13) +
         __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
}

// The sums of four vectors, in lanes 0 to 3 (4 to 7 repeat them).
TREMOLO_INLINE Vector sums(Vector a, Vector b, Vector c, Vector d) {
  const Vector t = fold_pairs(fold(a, b), fold(c, d));
  return t + __builtin_shufflevector(t, t, 4, 5, 6, 7, 0, 1, 2, 3);
}

// The sums of eight.
TREMOLO_INLINE Vector sums(const Vector* v) {
  const Vector low = fold_pairs(fold(v[0], v[1]), fold(v[2], v[3]));
  const Vector high = fold_pairs(fold(v[4], v[5]), fold(v[6], v[7]));
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 8, 9, 10, 11) +
         __builtin_shufflevector(low, high, 4, 5, 6, 7, 12, 13, 14, 15);
}

}  // namespace tremolo::lanes
