// Adds matrices of elements in single precision directly where conjugate gradients multiply them
// (active_floats.h). K's blocks are stored entry by entry, so that sixteen blocks rotate at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "runtime/bodies/tets/elements/tet_element.h"

namespace tremolo {

// The parts of an element's exact tangent in addition to R K R^T, in single precision and rotated
// into space, for matrices that are summed in floats.

// With the symbols of TangentParts (tet_element.h): for each node R slopes_I, three columns, and R
// turned_I, three more, which only a damped tangent has. `right` are these times their middle
// matrices. gradient: R g_I. Each column is four floats, the last one zero.
inline constexpr std::size_t kRanks = 6;
struct FloatParts {
  alignas(16) float left[4 * kRanks * kMostNodes];
  alignas(16) float right[4 * kRanks * kMostNodes];
  alignas(16) float gradient[4 * kMostNodes];
  float couple = 0.0F;
  bool damped = false;
};

void find_float_parts(const TetElement& element, const Elasticity& elasticity,
                      const TetShape& shape, const TangentFactors& factors, FloatParts& parts);

// Position of an element's block in the matrix.
struct BlockPlace {
  std::uint32_t place = 0;
  bool turned = false;  // the matrix stores its transpose
};

// A column of a block is four numbers, the last one zero. Four blocks form a group: their first
// columns one after the other, then their second, then their third ones.
inline constexpr std::size_t kGroupBlocks = 4;
inline constexpr std::size_t kColumnStride = 4 * kGroupBlocks;
inline constexpr std::size_t kFloatGroup = 3 * kColumnStride;
constexpr std::size_t first_float(std::size_t block) {
  return kFloatGroup * (block / kGroupBlocks) + 4 * (block % kGroupBlocks);
}
inline constexpr std::uint32_t kNowhere = ~std::uint32_t{0};

// The matrix.
struct FloatTarget {
  float* blocks = nullptr;
  // For each block of the pattern its number among `blocks` (first_float()); kNowhere if it is not
  // multiplied.
  const std::uint32_t* at = nullptr;
};

// K of one element for degree two (64 places for 55 blocks) and degree one (16 for 10): for each
// entry of a block, by columns, the values of all places.
inline constexpr std::size_t kQuadraticPlaces = 64, kLinearPlaces = 16;
inline constexpr std::size_t kFloatStiffness = 9 * (kQuadraticPlaces + kLinearPlaces);
void pack_floats(std::span<const Eigen::Matrix3d> quadratic,
                 std::span<const Eigen::Matrix3d> linear, float* out);

// The element to add.
struct FloatElement {
  const BlockPlace* places = nullptr;  // by node_block()
  // A bit for each linear edge, whose rows and columns are added half and half to its ends; all
  // bits: the element of degree one.
  unsigned linear = 0;
  bool straight() const { return linear == 63U; }
};

// Adds factor R K R^T and mass times the integrals of the polynomials' products. stiffness: of
// pack_floats(), at the start of a cache line.
void add_turned(const FloatElement& element, const float* stiffness,
                const Eigen::Matrix3d& rotation, double factor, double mass,
                const FloatTarget& target);
// Adds the exact tangent: parts are subtracted from the same blocks.
void add_exact(const FloatElement& element, const float* stiffness, const Eigen::Matrix3d& rotation,
               double factor, double mass, const FloatParts& parts, const FloatTarget& target);

}  // namespace tremolo
