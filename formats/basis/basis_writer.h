// BasisData -> basis file (docs/basis-format.md).
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "common/result.h"
#include "formats/basis/basis_data.h"

namespace tremolo {

// kFull keeps every number as it is. kCompact rounds (formats/basis/compact_values.h): coefficients
// to f32, basis rows to 16 bits; all else, lambda and the rest positions among it, stays f64.
enum class BasisEncoding { kFull, kCompact };

// The bytes of the file. The same data give the same bytes. Errors (kContent) name the member
// whose shape does not fit the others, or, for kCompact, that holds a value that is not finite.
Result<std::vector<std::byte>> encode_basis(const BasisData& data,
                                            BasisEncoding encoding = BasisEncoding::kFull);

// A source of basis rows that no process holds as a whole. It fills `out`, 3*count x r, row-major,
// with the rows of the block's vertices first .. first+count-1. It is called in ascending order,
// once for each vertex, with kRowsAtOnce vertices except in the last call.
using RowSource = std::function<Status(std::size_t first, std::size_t count, double* out)>;
inline constexpr std::size_t kRowsAtOnce = 4096;
struct RowSources {
  RowSource surface;
  RowSource interior;
  RowSource render;  // called only if there is data.render
};

// write_basis in full encoding; the `rows` of the data's blocks are empty and come from `sources`,
// surface first, then render, then interior. Memory is needed for the data, the file's other
// sections and kRowsAtOnce vertices.
Status write_basis(const std::string& path, const BasisData& data, const RowSources& sources);

// encode_basis, written under a temporary name and renamed to `path`.
Status write_basis(const std::string& path, const BasisData& data,
                   BasisEncoding encoding = BasisEncoding::kFull);

}  // namespace tremolo
