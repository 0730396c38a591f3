// BasisData -> basis file (docs/basis-format.md).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/result.h"
#include "formats/basis_data.h"

namespace tremolo {

// kFull keeps every number as it is. kCompact rounds (formats/compact_values.h): coefficients to
// f32, basis rows to 16 bits; all else, lambda and the rest positions among it, stays f64.
enum class BasisEncoding { kFull, kCompact };

// The bytes of the file. The same data give the same bytes. Errors (kContent) name the member
// whose shape does not fit the others, or, for kCompact, that holds a value that is not finite.
Result<std::vector<std::byte>> encode_basis(const BasisData& data,
                                            BasisEncoding encoding = BasisEncoding::kFull);

// encode_basis, written under a temporary name and renamed to `path`.
Status write_basis(const std::string& path, const BasisData& data,
                   BasisEncoding encoding = BasisEncoding::kFull);

}  // namespace tremolo
