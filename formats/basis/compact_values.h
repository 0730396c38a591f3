// Smaller numbers for a basis file (docs/basis-format.md, "Compact"), and back.
//
//     coefficient = f32 * scale           scale a power of two: only the rounding to f32 is lost
//     U_vi        = i16 * scale_i         scale_i = max_v |U_vi| / 32767, one a column
#pragma once

#include <cstdint>
#include <vector>

#include "common/result.h"
#include "formats/basis/basis_data.h"

namespace tremolo {

// The rounded numbers of a compact file.
struct CompactValues {
  std::vector<double> coefficient_scales;  // of cubic and quartic, positive
  std::vector<double> basis_scales;  // r, for the columns of all blocks; 1 for a column of zeros
  // Each within a relative error of 2^-24 of the original / scale; values below 1e-38 of the
  // largest within 1e-45 of the largest.
  std::vector<float> cubic;
  std::vector<float> quartic;
  std::vector<double> strain_scale;  // one
  // G/scale, rounded in the same way. Its diagonal is larger by (c + 1) 2^-24 for c strain terms,
  // more than the rounding error of the matrix: no strain rate gains energy.
  std::vector<float> strain_gram;
  // Rows of the blocks, row-major; each entry within half a scale of the original, zeros exact.
  std::vector<std::int16_t> surface;
  std::vector<std::int16_t> interior;
  std::vector<std::int16_t> render;
};

// Every block has r columns or no row. Errors (kContent) name the member of the data that holds a
// value that is not finite or too large.
Result<CompactValues> compact_values(const BasisData& data);

// True for a scale that a reader accepts: positive, and finite times any 16-bit number.
bool is_scale(double scale);

}  // namespace tremolo
