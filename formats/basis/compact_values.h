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
// cubic, quartic: each within 2^-24 of its own size of the original / scale, those below 1e-38 of
// the largest within 1e-45 of the largest. coefficient_scales: of the two, positive.
// strain_gram: likewise, its diagonal larger by (c + 1) 2^-24 for c strain terms, which is more
// than what rounding can take from the matrix: no strain rate gains energy. surface, interior,
// render: the rows, row-major; each entry within half a scale of the original, zeros exact.
// basis_scales: r, one a column of all three; 1 for a column of zeros.
struct CompactValues {
  std::vector<double> coefficient_scales;
  std::vector<double> basis_scales;
  std::vector<float> cubic;
  std::vector<float> quartic;
  std::vector<double> strain_scale;  // one
  std::vector<float> strain_gram;    // G/scale
  std::vector<std::int16_t> surface;
  std::vector<std::int16_t> interior;
  std::vector<std::int16_t> render;
};

// Every block has r columns or no row. Errors (kContent) name the member of the data that holds a
// value that is not finite or too large.
Result<CompactValues> compact_values(const BasisData& data);

// What a reader accepts as a scale: positive, and every 16-bit number times it is finite.
bool is_scale(double scale);

}  // namespace tremolo
