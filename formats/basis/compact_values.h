// Smaller numbers for a basis file (docs/basis-format.md, "Compact"), and back.
//
//     coefficient = f32 * scale           scale a power of two: only the rounding to f32 is lost
//     U_vi        = i16 * scale_i         scale_i = max_v |U_vi| / 32767, one a column
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/result.h"
#include "formats/basis/basis_data.h"

namespace tremolo {

// scale: positive; values: each within 2^-24 of its own size of the original / scale, those below
// 1e-38 of the largest within 1e-45 of the largest.
struct ScaledFloats {
  double scale = 1.0;
  std::vector<float> values;
};

// kContent if a value is not finite; `name` is for the message.
Result<ScaledFloats> to_scaled_floats(std::span<const double> values, const char* name);

// Rows of a basis, and what to call them in a message.
struct NamedRows {
  const BasisRows* rows;
  const char* name;
};

// One scale a column for the rows of all blocks, which have r columns or no row at all. A column
// of zeros gets 1. kContent if a value is not finite.
Result<std::vector<double>> column_scales(std::span<const NamedRows> blocks, std::size_t r);

// Row-major as the rows; each within half a scale of the original, zeros exact.
std::vector<std::int16_t> to_scaled_integers(const BasisRows& rows, std::span<const double> scales);

// What a reader accepts as a scale: positive, and every 16-bit number times it is finite.
bool is_scale(double scale);

}  // namespace tremolo
