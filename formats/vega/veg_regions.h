// Sets, materials and regions of VegaFEM's files -> regions of the mesh.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

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

}  // namespace tremolo
