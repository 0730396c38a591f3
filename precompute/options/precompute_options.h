// The command line of tremolo-precompute as values.
#pragma once

#include <string>

#include "formats/basis/basis_writer.h"
#include "precompute/problem/model_request.h"

namespace tremolo {

struct PrecomputeOptions : ModelRequest {
  std::string output_path;
  std::string config_path;  // value of --config; empty: none
  BasisEncoding encoding = BasisEncoding::kFull;
  std::string
      import_basis;  // VegaFEM's .U and .cub: import instead of solving (precompute/vega/import.h)
  std::string import_cubic;
  bool keep_elements = false;  // the tetrahedra and their masses stay in the file, for bones
  bool error_budget = false;   // measure what mesh, basis and step leave out (error_budget.h)
  bool mass_given = false;     // --mass was given: an import orthonormalises its basis in it
  std::string modes_vtu;  // file for the modes on the tetrahedra, for ParaView; empty: not written
  std::string command_line;  // for the file's provenance
};

}  // namespace tremolo
