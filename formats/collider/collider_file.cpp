#include "formats/collider/collider_file.h"

#include <algorithm>
#include <array>
#include <utility>

#include "formats/sections/section_file.h"
#include "formats/sections/section_writer.h"

namespace tremolo {
namespace {

using namespace collider_layout;

std::array<SectionShape, 4> collider_shapes(std::uint64_t nodes) {
  return {{{kCounts, ElementType::kU64, 3, 1, true},
           {kFrame, ElementType::kF64, kFrameSize, 1, true},
           {kDistances, ElementType::kF32, nodes, 1, true},
           {kProvenance, ElementType::kU8, kAnyRows, 1}}};
}

// Values in the list of sections that are not in the caller's data.
struct GridNumbers {
  std::array<std::uint64_t, 3> counts;
  std::array<double, kFrameSize> frame;
};

template <class Use>
auto with_collider_sections(const ColliderData& data, const Use& use)
    -> decltype(use(SectionList{})) {
  const GridNodes& nodes = data.nodes;
  if (const Result<DistanceGrid> grid = DistanceGrid::create(nodes, data.distances); !grid)
    return grid.error();
  const GridNumbers numbers = {
      {nodes.counts[0], nodes.counts[1], nodes.counts[2]},
      {nodes.origin.x(), nodes.origin.y(), nodes.origin.z(), nodes.spacing}};
  auto [counts, frame, distances, provenance] = collider_shapes(nodes.size());
  SectionList list{kKind,
                   kMinor,
                   {{counts, bytes_of(numbers.counts)},
                    {frame, bytes_of(numbers.frame)},
                    {distances, bytes_of(data.distances)}}};
  provenance.rows = data.provenance.size();
  if (provenance.rows > 0) list.sections.push_back({provenance, bytes_of(data.provenance)});
  return use(list);
}

Result<GridNodes> read_nodes(SectionFile& file) {
  if (!file.has(kCounts) || !file.has(kFrame) || file.find(kCounts)->size != 3 * 8 ||
      file.find(kFrame)->size != kFrameSize * 8)
    return file.error_at("table", kHeaderSize,
                         "section 'grid_counts' or 'grid_frame' is missing or has another shape");
  const auto counts = file.elements<std::uint64_t>(kCounts);
  if (!counts) return counts.error();
  const auto frame = file.finite<double>(kFrame);
  if (!frame) return frame.error();
  GridNodes nodes;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // A count above the limit stays above it when it is narrowed.
    nodes.counts[axis] =
        static_cast<std::uint32_t>(std::min<std::uint64_t>((*counts)[axis], kMostGridNodes + 1));
    nodes.origin[axis] = (*frame)[axis];
  }
  nodes.spacing = (*frame)[3];
  if (Status status = check(nodes); !status)
    return file.error_at(kCounts, file.find(kCounts)->offset, status.error().message);
  return nodes;
}

Result<ColliderFile> read_sections(Result<SectionFile> file) {
  if (!file) return file.error();
  const Result<GridNodes> nodes = read_nodes(*file);
  if (!nodes) return nodes.error();
  if (Status status = file->check_shapes(collider_shapes(nodes->size())); !status)
    return status.error();
  const Result<std::span<const float>> distances = file->finite<float>(kDistances);
  if (!distances) return distances.error();
  std::string provenance;
  if (file->has(kProvenance))
    if (Status status = take(provenance, file->text(kProvenance)); !status) return status.error();
  Result<DistanceGrid> grid = DistanceGrid::create(*nodes, *distances);
  if (!grid)
    return file->error_at(kDistances, file->find(kDistances)->offset, grid.error().message);
  return ColliderFile{std::move(*grid), std::move(provenance)};
}

}  // namespace

Result<std::vector<std::byte>> encode_collider(const ColliderData& data) {
  return with_collider_sections(data,
                                [](const SectionList& list) { return encode_sections(list); });
}

Status write_collider(const std::string& path, const ColliderData& data) {
  return with_collider_sections(
      data, [&path](const SectionList& list) { return write_sections(path, list); });
}

Result<ColliderFile> read_collider(const std::string& path) {
  return read_sections(SectionFile::open(path, kKind));
}

Result<ColliderFile> read_collider(std::span<const std::byte> bytes, const std::string& name) {
  return read_sections(SectionFile::from_memory(bytes, name, kKind));
}

}  // namespace tremolo
