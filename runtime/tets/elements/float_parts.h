// The parts of an element's exact tangent in addition to R K R^T, in single precision and rotated
// into space, for matrices that are summed in floats (float_blocks.h).
#pragma once

#include <cstddef>

#include "runtime/tets/elements/tet_element.h"

namespace tremolo {

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

}  // namespace tremolo
