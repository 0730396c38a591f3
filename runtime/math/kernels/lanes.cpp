#include "runtime/math/kernels/lanes.h"

#include <cstdint>

namespace tremolo {
namespace {

constexpr LaneMasks make_masks() {
  LaneMasks masks{};
  for (std::size_t row = 0; row <= kVectorLanes; ++row)
    for (std::size_t lane = 0; lane < row; ++lane)
      masks.row[row][lane] = __builtin_bit_cast(double, ~std::uint64_t{0});
  return masks;
}

}  // namespace

constinit const LaneMasks kLaneMasks = make_masks();

}  // namespace tremolo
