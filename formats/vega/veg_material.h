// The materials of VegaFEM's files.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "common/material.h"
#include "common/result.h"

namespace tremolo {

// kind: the file's word; numbers: those after it, density (kg/m^3) first, moduli in Pa.
//   ENU                           density E nu
//   ORTHOTROPIC or ..._N3G3R9     density E1 E2 E3 nu12 nu23 nu31 G12 G23 G31 R (nine, row by row)
//   ORTHOTROPIC_N3G3              the same without R
//   ORTHOTROPIC_N1G1R9, _N1G1, _N1R9, _N1    density E1 E2 E3 nu [G] [R]
// R's columns are the material's axes, else x, y, z. One nu and G (default 1) mean nu_ij = nu
// sqrt(E_i/E_j), G_ij = G sqrt(E_i E_j) / (2 (1 + nu)) (Li & Barbic 2014). Errors (kContent):
// another kind (MOONEYRIVLIN is not StVK), another count of numbers, those of check_material.
Result<Material> veg_material(std::string_view kind, std::span<const double> numbers);

}  // namespace tremolo
