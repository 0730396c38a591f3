#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include "formats/msh/msh_input.h"

namespace tremolo {
namespace {

// A block's vertices are added to the set of each group of its entity: without a limit, many groups
// and many blocks would make sets far larger than the file.
constexpr std::size_t kMaxGroupsOfEntity = 64;

// Reads a count and as many numbers. each: called with every number.
template <class Each>
bool read_tags(MshInput& input, std::string_view items, std::string_view item, const Each& each) {
  std::uint64_t count = 0;
  std::int64_t number = 0;
  if (!input.size(count, "a number of " + std::string(items)) ||
      !input.fits(count, {.integers = 1}, items))
    return false;
  for (std::uint64_t n = 0; n < count; ++n) {
    if (!input.integer(number, item)) return false;
    each(number);
  }
  return true;
}

// For a partitioned entity: reads the entity that it is a part of, and its partitions. Its groups
// are those of the whole, so that a file has the same groups as before partitioning; boundaries
// between partitions are of a lower dimension and have no groups.
bool read_parent(MshInput& input, int dimension, const MshEntities& entities,
                 const std::vector<std::int64_t>** groups_of_parent) {
  static const std::vector<std::int64_t> kNone;
  std::int64_t parent_dimension = 0;
  std::int64_t parent = 0;
  if (!input.integer(parent_dimension, "the dimension of a parent entity") ||
      !input.integer(parent, "the tag of a parent entity") ||
      !read_tags(input, "partitions", "a partition", [](std::int64_t) {}))
    return false;
  const auto found = entities.find({dimension, parent});
  *groups_of_parent =
      parent_dimension == dimension && found != entities.end() ? &found->second : &kNone;
  return true;
}

// The body of one entity: a point has 3 coordinates, the others a bounding box of 6 numbers and a
// list of the entities around them.
bool read_entity(MshInput& input, int dimension, bool partitioned, MshEntities& entities) {
  std::int64_t tag = 0;
  double ignored = 0;
  const std::vector<std::int64_t>* of_parent = nullptr;
  if (!input.integer(tag, "the tag of an entity") ||
      (partitioned && !read_parent(input, dimension, entities, &of_parent)))
    return false;
  for (int n = 0; n < (dimension == 0 ? 3 : 6); ++n)
    if (!input.real(ignored, "a coordinate of an entity")) return false;
  std::vector<std::int64_t> groups;
  const auto keep = [&groups](std::int64_t group) { groups.push_back(group); };
  if (!read_tags(input, "physical tags", "a physical tag", keep)) return false;
  if (of_parent != nullptr) groups = *of_parent;
  if (!groups.empty()) {
    std::vector<std::int64_t>& known = entities[{dimension, tag}];
    known.insert(known.end(), groups.begin(), groups.end());
  }
  return dimension == 0 ||
         read_tags(input, "bounding entities", "the tag of a bounding entity", [](std::int64_t) {});
}

// The four numbers with which a block of nodes or elements begins.
struct Block {
  std::int64_t dimension = 0;
  std::int64_t entity = 0;
  std::int64_t kind = 0;  // nodes: parametric or not; elements: the type
  std::uint64_t count = 0;
};

Status read_block(MshInput& input, std::uint64_t left, std::string_view items, Block& block) {
  if (!input.integer(block.dimension, "the dimension of an entity")) return input.error();
  if (block.dimension < 0 || block.dimension > 3)
    return input.problem("expected a dimension from 0 to 3, found " +
                         std::to_string(block.dimension));
  if (!input.integer(block.entity, "the tag of an entity") ||
      !input.integer(block.kind, "the kind of a block") ||
      !input.size(block.count, "the number of items in a block"))
    return input.error();
  if (block.count > left)
    return input.problem("expected at most " + std::to_string(left) + " " + std::string(items) +
                         " in a block, found " + std::to_string(block.count));
  return Success{};
}

Status read_ids(MshInput& input, std::uint64_t count, std::vector<std::int64_t>& ids) {
  ids.resize(count);
  for (std::int64_t& id : ids) {
    std::uint64_t tag = 0;
    if (!input.size(tag, "a node tag")) return input.error();
    if (!std::in_range<std::int64_t>(tag))
      return input.problem("expected a node tag below 2^63, found " + std::to_string(tag));
    id = tag;
  }
  return Success{};
}

// All tags of a block, then all coordinates.
Status read_node_block(MshInput& input, const Block& block, std::vector<std::int64_t>& ids,
                       MeshBuilder& builder) {
  if (block.kind != 0 && block.kind != 1)
    return input.problem("expected 0 or 1 (parametric nodes), found " + std::to_string(block.kind));
  const std::size_t parameters = block.kind == 1 ? block.dimension : 0;
  if (!input.fits(block.count, {.sizes = 1, .reals = 3 + parameters}, "nodes"))
    return input.error();
  Status status = read_ids(input, block.count, ids);
  if (!status) return status;
  for (std::int64_t id : ids) {
    Eigen::Vector3d x;
    for (double& coordinate : x)
      if (!input.real(coordinate, "a coordinate")) return input.error();
    double ignored = 0;
    for (std::size_t p = 0; p < parameters; ++p)
      if (!input.real(ignored, "a parametric coordinate")) return input.error();
    if (!builder.add_vertex(id, x)) return input.problem(builder.complaint());
  }
  return Success{};
}

struct Elements {
  std::vector<std::int64_t> nodes;
  std::vector<VertexId> vertices;
  std::vector<VertexId> of_block;
};

// in_set: the block's entity is in a physical group.
Status read_element_block(MshInput& input, const Block& block, bool in_set, Elements& elements,
                          MeshBuilder& builder) {
  const CellKind* kind = msh_cell(block.kind);
  if (kind == nullptr)
    return input.problem("expected an element type of the MSH format, found " +
                         std::to_string(block.kind));
  const std::size_t node_count = kind->nodes;
  if (!input.fits(block.count, {.sizes = 1 + node_count}, kind->plural)) return input.error();
  elements.of_block.clear();
  for (std::uint64_t e = 0; e < block.count; ++e) {
    std::uint64_t tag = 0;
    if (!input.size(tag, "an element tag")) return input.error();
    const std::int64_t id = tag;
    Status status = read_ids(input, node_count, elements.nodes);
    if (!status) return status;
    if (!builder.resolve(id, elements.nodes, elements.vertices) ||
        !builder.add_cell(id, *kind, elements.vertices, in_set))
      return input.problem(builder.complaint());
    elements.of_block.insert(elements.of_block.end(), elements.vertices.begin(),
                             elements.vertices.end());
  }
  return Success{};
}

// Number of blocks and of items, with the lowest and highest tag, which are not needed.
bool read_totals(MshInput& input, std::string_view items, std::uint64_t& blocks,
                 std::uint64_t& count) {
  std::uint64_t ignored = 0;
  return input.begin_data() && input.size(blocks, "the number of blocks") &&
         input.size(count, "the number of " + std::string(items)) &&
         input.size(ignored, "the lowest tag") && input.size(ignored, "the highest tag") &&
         input.fits(blocks, {.integers = 3, .sizes = 1}, "blocks") &&
         input.fits(count, {.sizes = 1}, items);
}

// Tag 0 is no group.
std::int64_t first_group(const std::vector<std::int64_t>& tags) {
  const auto found =
      std::find_if(tags.begin(), tags.end(), [](std::int64_t tag) { return tag != 0; });
  return found != tags.end() ? *found : 0;
}

Error missing(const MshInput& input, std::string_view items, std::uint64_t count,
              std::uint64_t left) {
  return input.problem("expected " + std::to_string(count) + " " + std::string(items) +
                       " in all blocks, found " + std::to_string(count - left));
}

}  // namespace

Status read_msh4_entities(MshInput& input, bool partitioned, MshEntities& entities) {
  std::uint64_t counts[4] = {};
  std::uint64_t partitions = 0;
  std::uint64_t ghosts = 0;
  if (!input.begin_data()) return input.error();
  if (partitioned) {
    if (!input.size(partitions, "the number of partitions") ||
        !input.size(ghosts, "the number of ghost entities") ||
        !input.fits(ghosts, {.integers = 2}, "ghost entities"))
      return input.error();
    std::int64_t ignored = 0;
    for (std::uint64_t n = 0; n < 2 * ghosts; ++n)
      if (!input.integer(ignored, "a ghost entity")) return input.error();
  }
  for (std::uint64_t& count : counts)
    if (!input.size(count, "a number of entities")) return input.error();
  for (int dimension = 0; dimension < 4; ++dimension) {
    const MshItem least{.integers = 1, .sizes = 1, .reals = 3};
    if (!input.fits(counts[dimension], least, "entities")) return input.error();
    for (std::uint64_t n = 0; n < counts[dimension]; ++n)
      if (!read_entity(input, dimension, partitioned, entities)) return input.error();
  }
  for (const auto& [entity, groups] : entities)
    if (groups.size() > kMaxGroupsOfEntity)
      return input.problem("expected at most " + std::to_string(kMaxGroupsOfEntity) +
                           " physical groups of an entity, found " + std::to_string(groups.size()) +
                           " of entity " + std::to_string(entity.second));
  input.end_data();
  if (!input.end_section(partitioned ? "PartitionedEntities" : "Entities")) return input.error();
  return Success{};
}

Status read_msh4_nodes(MshInput& input, MeshBuilder& builder) {
  std::uint64_t blocks = 0;
  std::uint64_t count = 0;
  if (!read_totals(input, "nodes", blocks, count)) return input.error();
  builder.reserve_vertices(count);
  std::vector<std::int64_t> ids;
  std::uint64_t left = count;
  for (std::uint64_t n = 0; n < blocks; ++n) {
    Block block;
    Status status = read_block(input, left, "nodes", block);
    if (status) status = read_node_block(input, block, ids, builder);
    if (!status) return status;
    left -= block.count;
  }
  if (left > 0) return missing(input, "nodes", count, left);
  if (!builder.seal_vertices()) return input.problem(builder.complaint());
  input.end_data();
  if (!input.end_section("Nodes")) return input.error();
  return Success{};
}

Status read_msh4_elements(MshInput& input, const MshEntities& entities, MeshBuilder& builder,
                          MshGroups& groups, std::vector<std::int64_t>& volume_of_tet) {
  std::uint64_t blocks = 0;
  std::uint64_t count = 0;
  if (!read_totals(input, "elements", blocks, count)) return input.error();
  Elements elements;
  std::uint64_t left = count;
  std::size_t shared = 0;
  for (std::uint64_t n = 0; n < blocks; ++n) {
    Block block;
    Status status = read_block(input, left, "elements", block);
    const int dimension = static_cast<int>(block.dimension);
    const auto entity = entities.find({dimension, block.entity});
    const bool grouped = entity != entities.end();
    if (status)
      status = read_element_block(input, block, grouped && first_group(entity->second) != 0,
                                  elements, builder);
    if (!status) return status;
    left -= block.count;
    const std::size_t before = volume_of_tet.size();
    volume_of_tet.resize(builder.mesh().tetrahedra.size(),
                         grouped && dimension == 3 ? first_group(entity->second) : 0);
    if (!grouped) continue;
    if (dimension == 3 && entity->second.size() > 1) shared += volume_of_tet.size() - before;
    for (std::int64_t physical : entity->second) groups.add(dimension, physical, elements.of_block);
  }
  if (left > 0) return missing(input, "elements", count, left);
  input.end_data();
  if (!input.end_section("Elements")) return input.error();
  if (shared > 0)
    builder.add_note(std::to_string(shared) +
                     " tetrahedra of several physical groups are in the region of the first");
  return Success{};
}

}  // namespace tremolo
