#include "formats/vega/veg_regions.h"

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

namespace tremolo {

namespace {

// Without a name the tetrahedra would be of no region, and get the default material unseen.
std::string name_of(const FileMaterial& material) {
  return material.region.empty() ? "(unnamed)" : material.region;
}

}  // namespace

void set_veg_regions(const VegRegions& file, MeshBuilder& builder) {
  constexpr const char* kAll = "allElements";
  std::map<std::string_view, std::size_t> material_of_name;
  for (std::size_t i = 0; i < file.materials.size(); ++i)
    if (material_of_name.try_emplace(file.materials[i].region, i).second) {
      FileMaterial material = file.materials[i];
      material.region = name_of(material);
      builder.add_material(std::move(material));
    }
  std::vector<std::int64_t> material_of(builder.mesh().tetrahedra.size(), -1);
  // Backwards, with only the last of several regions of one set: the work is bounded by the file.
  std::set<std::string_view> done;
  std::vector<bool> shared(material_of.size(), false);
  std::size_t unknown = 0;
  for (auto region = file.regions.rbegin(); region != file.regions.rend(); ++region) {
    const auto& [set, material] = *region;
    const auto found = material_of_name.find(material);
    const auto elements = file.sets.find(set);
    if (found == material_of_name.end() || (elements == file.sets.end() && set != kAll)) {
      ++unknown;
      continue;
    }
    if (!done.insert(set).second) continue;
    const auto put = [&, label = std::int64_t(found->second)](std::size_t element) {
      if (material_of[element] < 0)
        material_of[element] = label;
      else if (material_of[element] != label)
        shared[element] = true;
    };
    if (elements == file.sets.end())
      for (std::size_t element = 0; element < material_of.size(); ++element) put(element);
    else
      for (std::int32_t element : elements->second) put(element);
  }
  if (unknown > 0)
    builder.add_note(std::to_string(unknown) +
                     " regions name a set or a material that the file does not have");
  const auto several = std::count(shared.begin(), shared.end(), true);
  if (several > 0)
    builder.add_note(std::to_string(several) +
                     " tetrahedra are in several regions: the last decides");
  builder.set_regions(material_of, [&file](std::int64_t label) {
    return label < 0 ? std::string() : name_of(file.materials[label]);
  });
}

}  // namespace tremolo
