// The command line of tremolo-precompute as values.
#pragma once

#include <string>

#include "formats/basis/basis_writer.h"
#include "precompute/problem/model_request.h"

namespace tremolo {

struct PrecomputeOptions : ModelRequest {
  std::string output_path;
  std::string config_path;  // of --config; empty: none
  BasisEncoding encoding = BasisEncoding::kFull;
  std::string import_basis;  // VegaFEM's .U and .cub: nothing is solved (precompute/vega/import.h)
  std::string import_cubic;
  bool mass_given = false;   // by the user: an import then makes its basis orthonormal in it
  std::string modes_vtu;     // the modes on the tetrahedra, for ParaView; empty: not written
  std::string command_line;  // for the file's provenance
};

}  // namespace tremolo
