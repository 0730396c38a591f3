// The materials and regions of VegaFEM's files -> regions of the mesh.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/material.h"
#include "common/result.h"
#include "formats/mesh/mesh_builder.h"

namespace tremolo {

// sets: elements, from 0, all of them in the mesh. materials: as they follow each other; of several
// with one name the first counts. regions: {set, material} by name; the set "allElements" is always
// there.
struct VegRegions {
  std::map<std::string, std::vector<std::int32_t>> sets;
  std::vector<FileMaterial> materials;
  std::vector<std::pair<std::string, std::string>> regions;
};

// Gives the builder, which has all elements, the regions and their materials. A region of the mesh
// has one material and its name. As in VegaFEM, the last region that lists an element decides; such
// overlaps, and regions with unknown names, are noted.
void set_veg_regions(const VegRegions& file, MeshBuilder& builder);

// The materials of VegaFEM's files.

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
