#include <algorithm>
#include <cstddef>
#include <numeric>
#include <string>

#include "formats/msh/msh_input.h"

namespace tremolo {
namespace {

constexpr std::int64_t kMaxTags = 1000;  // far above what partitioned meshes need

// The target of the file's elements; its lists are reused for each element.
struct Reading {
  MshInput& input;
  MeshBuilder& builder;
  MshGroups& groups;
  std::vector<std::int64_t> nodes;
  std::vector<VertexId> vertices;
  std::vector<std::int64_t>& physical_of_tet;
};

const CellKind* read_type(Reading& reading, std::int64_t& type, Status& status) {
  if (!reading.input.integer(type, "an element type")) {
    status = reading.input.error();
    return nullptr;
  }
  const CellKind* kind = msh_cell(type);
  if (kind == nullptr)
    status = reading.input.problem("expected an element type of the MSH format, found " +
                                   std::to_string(type));
  return kind;
}

Status check_tags(Reading& reading, std::int64_t tags) {
  if (tags >= 0 && tags <= kMaxTags) return Success{};
  return reading.input.problem("expected 0 to " + std::to_string(kMaxTags) +
                               " tags of an element, found " + std::to_string(tags));
}

// Tags and nodes; the first tag is the physical group.
Status read_body(Reading& reading, std::int64_t id, std::int64_t type, const CellKind& kind,
                 std::int64_t tags) {
  std::int64_t physical = 0;
  for (std::int64_t t = 0; t < tags; ++t) {
    std::int64_t tag = 0;
    if (!reading.input.integer(tag, "a tag of an element")) return reading.input.error();
    if (t == 0) physical = tag;
  }
  reading.nodes.resize(kind.nodes);
  for (std::int64_t& node : reading.nodes)
    if (!reading.input.integer(node, "a node of an element")) return reading.input.error();
  if (!reading.builder.resolve(id, reading.nodes, reading.vertices) ||
      !reading.builder.add_cell(id, kind, reading.vertices, physical != 0))
    return reading.input.problem(reading.builder.complaint());
  reading.groups.add(msh_dimension(type), physical, reading.vertices);
  reading.physical_of_tet.resize(reading.builder.mesh().tetrahedra.size(), physical);
  return Success{};
}

Status read_text_element(Reading& reading) {
  std::int64_t id = 0;
  std::int64_t type = 0;
  std::int64_t tags = 0;
  if (!reading.input.integer(id, "an element id")) return reading.input.error();
  Status status = Success{};
  const CellKind* kind = read_type(reading, type, status);
  if (kind == nullptr) return status;
  if (!reading.input.integer(tags, "a number of tags")) return reading.input.error();
  status = check_tags(reading, tags);
  return status ? read_body(reading, id, type, *kind, tags) : status;
}

// A block: type, number of elements, number of tags; then the elements. Returns how many.
Result<std::uint64_t> read_binary_block(Reading& reading, std::uint64_t left) {
  std::int64_t type = 0;
  std::int64_t count = 0;
  std::int64_t tags = 0;
  Status status = Success{};
  const CellKind* kind = read_type(reading, type, status);
  if (kind == nullptr) return status.error();
  if (!reading.input.integer(count, "a number of elements")) return reading.input.error();
  if (count < 1 || std::cmp_greater(count, left))
    return reading.input.problem("expected 1 to " + std::to_string(left) +
                                 " elements in a block, found " + std::to_string(count));
  if (!reading.input.integer(tags, "a number of tags")) return reading.input.error();
  status = check_tags(reading, tags);
  if (!status) return status.error();
  for (std::int64_t e = 0; e < count; ++e) {
    std::int64_t id = 0;
    if (!reading.input.integer(id, "an element id")) return reading.input.error();
    status = read_body(reading, id, type, *kind, tags);
    if (!status) return status.error();
  }
  return count;
}

// Version 2 writes an element once for each of its physical groups. Of tetrahedra that differ only
// in the group, the first is kept.
void drop_repeats_of_groups(Reading& reading) {
  std::vector<Tetrahedron>& tets = reading.builder.mesh().tetrahedra;
  std::vector<std::int64_t>& physical = reading.physical_of_tet;
  std::vector<std::size_t> order(tets.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return tets[a] != tets[b] ? tets[a] < tets[b] : a < b;
  });
  std::vector<bool> drop(tets.size(), false);
  std::size_t first = 0;
  for (std::size_t n = 1; n < order.size(); ++n) {
    if (tets[order[n]] != tets[order[first]])
      first = n;
    else if (physical[order[n]] != physical[order[n - 1]])
      drop[order[n]] = true;
  }
  std::size_t kept = 0;
  for (std::size_t t = 0; t < tets.size(); ++t) {
    if (drop[t]) continue;
    tets[kept] = tets[t];
    physical[kept++] = physical[t];
  }
  const std::size_t dropped = tets.size() - kept;
  tets.resize(kept);
  physical.resize(kept);
  if (dropped > 0)
    reading.builder.add_note(std::to_string(dropped) +
                             " tetrahedra of several physical groups are taken once, in the region "
                             "of the first");
}

}  // namespace

Status read_msh2_nodes(MshInput& input, MeshBuilder& builder) {
  std::uint64_t count = 0;
  if (!input.text().read(count, "the number of nodes") || !input.begin_data() ||
      !input.fits(count, {.integers = 1, .reals = 3}, "nodes"))
    return input.error();
  builder.reserve_vertices(count);
  for (std::uint64_t n = 0; n < count; ++n) {
    std::int64_t id = 0;
    Eigen::Vector3d x;
    if (!input.integer(id, "a node id") || !input.real(x[0], "a coordinate") ||
        !input.real(x[1], "a coordinate") || !input.real(x[2], "a coordinate"))
      return input.error();
    if (!builder.add_vertex(id, x)) return input.problem(builder.complaint());
  }
  if (!builder.seal_vertices()) return input.problem(builder.complaint());
  input.end_data();
  if (!input.end_section("Nodes")) return input.error();
  return Success{};
}

Status read_msh2_elements(MshInput& input, MeshBuilder& builder, MshGroups& groups,
                          std::vector<std::int64_t>& volume_of_tet) {
  std::uint64_t count = 0;
  if (!input.text().read(count, "the number of elements") || !input.begin_data() ||
      !input.fits(count, {.integers = 2}, "elements"))
    return input.error();
  Reading reading{input, builder, groups, {}, {}, volume_of_tet};
  for (std::uint64_t done = 0; done < count;) {
    if (input.binary()) {
      const Result<std::uint64_t> block = read_binary_block(reading, count - done);
      if (!block) return block.error();
      done += *block;
    } else {
      Status status = read_text_element(reading);
      if (!status) return status;
      ++done;
    }
  }
  input.end_data();
  if (!input.end_section("Elements")) return input.error();
  drop_repeats_of_groups(reading);
  return Success{};
}

}  // namespace tremolo
