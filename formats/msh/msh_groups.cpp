#include "formats/msh/msh_groups.h"

#include <algorithm>
#include <limits>

namespace tremolo {
namespace {

constexpr const char* kDimensionNames[] = {"point", "curve", "surface", "volume"};

// The magnitude of a tag; the one value without a positive counterpart stays apart.
std::int64_t magnitude(std::int64_t tag) {
  if (tag == std::numeric_limits<std::int64_t>::min()) return tag;
  return tag < 0 ? -tag : tag;
}

}  // namespace

int msh_dimension(std::int64_t type) {
  constexpr int kPoints[] = {15};
  constexpr int kLines[] = {1, 8, 26, 27, 28};
  constexpr int kSurfaces[] = {2, 3, 9, 10, 16, 20, 21, 22, 23, 24, 25};
  const auto is_one_of = [type](std::span<const int> types) {
    return std::find(types.begin(), types.end(), type) != types.end();
  };
  return is_one_of(kPoints) ? 0 : is_one_of(kLines) ? 1 : is_one_of(kSurfaces) ? 2 : 3;
}

bool MshGroups::read_names(MshInput& input) {
  TextScanner& text = input.text();
  std::uint64_t count = 0;
  if (!text.read(count, "the number of physical names") || !text.fits(count, 6, "physical names"))
    return false;
  for (std::uint64_t n = 0; n < count; ++n) {
    int dimension = 0;
    std::int64_t tag = 0;
    std::string name;
    if (!text.read(dimension, "the dimension of a physical group") ||
        !text.read(tag, "the tag of a physical group") ||
        !text.read_quoted(name, "the name of a physical group"))
      return false;
    if (dimension < 0 || dimension > 3)
      return text.fail("a dimension from 0 to 3", std::to_string(dimension));
    if (name.empty()) continue;
    names_[{dimension, magnitude(tag)}] = name;
    given_.insert(name);
  }
  return input.end_section("PhysicalNames");
}

void MshGroups::add(int dimension, std::int64_t tag, std::span<const VertexId> vertices) {
  if (tag == 0) return;
  std::vector<VertexId>& members = members_[{dimension, magnitude(tag)}];
  members.insert(members.end(), vertices.begin(), vertices.end());
}

std::string MshGroups::name(int dimension, std::int64_t tag) const {
  const auto found = names_.find({dimension, magnitude(tag)});
  if (found != names_.end()) return found->second;
  std::string text = std::string(kDimensionNames[dimension]) + " " + std::to_string(magnitude(tag));
  while (given_.contains(text)) text += " (unnamed)";
  return text;
}

void MshGroups::give_to(MeshBuilder& builder, std::span<const std::int64_t> volume_of_tet) {
  for (auto& [key, members] : members_) {
    builder.add_to_set(name(key.first, key.second), members);
    std::vector<VertexId>().swap(members);
  }
  builder.set_regions(volume_of_tet,
                      [this](std::int64_t tag) { return tag == 0 ? std::string() : name(3, tag); });
}

}  // namespace tremolo
