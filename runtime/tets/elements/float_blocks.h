// Matrices of elements in single precision, added straight to where conjugate gradients multiply
// them (active_floats.h). K's blocks lie entry by entry, so that sixteen blocks turn at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "runtime/tets/elements/float_parts.h"
#include "runtime/tets/elements/tet_element.h"

namespace tremolo {

// A block of an element in the matrix: where, and whether the matrix stores its transpose.
struct BlockPlace {
  std::uint32_t place = 0;
  bool turned = false;
};

// A column of a block is four numbers, the last one zero. Four blocks make a group: their first
// columns one after the other, their second ones, their third ones.
inline constexpr std::size_t kGroupBlocks = 4;
inline constexpr std::size_t kColumnStride = 4 * kGroupBlocks;
inline constexpr std::size_t kFloatGroup = 3 * kColumnStride;
constexpr std::size_t first_float(std::size_t block) {
  return kFloatGroup * (block / kGroupBlocks) + 4 * (block % kGroupBlocks);
}
inline constexpr std::uint32_t kNowhere = ~std::uint32_t{0};

// at: of each block of the pattern its number among `blocks` (first_float()); kNowhere for what is
// not multiplied.
struct FloatTarget {
  float* blocks = nullptr;
  const std::uint32_t* at = nullptr;
};

// K of one element for degree two (64 places for 55 blocks) and degree one (16 for 10): of each
// place of a block by columns.
inline constexpr std::size_t kQuadraticPlaces = 64, kLinearPlaces = 16;
inline constexpr std::size_t kFloatStiffness = 9 * (kQuadraticPlaces + kLinearPlaces);
void pack_floats(std::span<const Eigen::Matrix3d> quadratic,
                 std::span<const Eigen::Matrix3d> linear, float* out);

// The element that is added. places: by node_block(). linear: a bit for each of its linear edges,
// whose rows and columns go half and half to their ends; all of them: the element of degree one.
struct FloatElement {
  const BlockPlace* places = nullptr;
  unsigned linear = 0;
  bool straight() const { return linear == 63U; }
};

// Adds factor R K R^T and mass times the shares of the polynomials' products. stiffness: of
// pack_floats(), at the beginning of a cache line.
void add_turned(const FloatElement& element, const float* stiffness,
                const Eigen::Matrix3d& rotation, double factor, double mass,
                const FloatTarget& target);
// Adds the exact tangent: parts are subtracted from those blocks.
void add_exact(const FloatElement& element, const float* stiffness, const Eigen::Matrix3d& rotation,
               double factor, double mass, const FloatParts& parts, const FloatTarget& target);

}  // namespace tremolo
