// BasisData -> basis file (docs/basis-format.md).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/result.h"
#include "formats/basis_data.h"

namespace tremolo {

// The bytes of the file. The same data give the same bytes. Errors (kContent) name the member
// whose shape does not fit the others.
Result<std::vector<std::byte>> encode_basis(const BasisData& data);

// encode_basis, written under a temporary name and renamed to `path`.
Status write_basis(const std::string& path, const BasisData& data);

}  // namespace tremolo
