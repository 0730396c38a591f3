// VegaFEM's binary mesh, .vegb. Little-endian; a text is an i32 length and the characters.
//
//   f64 version 1, i32 element type (1 tetrahedra, 2 cubes)
//   i32 vertices, f64 x y z each
//   i32 elements, i32 nodes of one, i32 vertices from 0 each
//   i32 materials; each: text name, i32 type, f64 properties: 1 E-nu: density, E, nu;
//       2 orthotropic: density, 3 E, 3 nu, 3 G and a rotation of 9; 3 Mooney-Rivlin: 4
//   i32 sets, of which the first, all elements, is not stored; each: text name, i32 count, i32
//       elements from 0
//   i32 regions; each: i32 material, i32 set
#include <limits>
#include <string>
#include <vector>

#include "common/packed_index.h"
#include "formats/file/scanner.h"
#include "formats/mesh/mesh_builder.h"
#include "formats/mesh/mesh_reader.h"
#include "formats/vega/veg_regions.h"

namespace tremolo {
namespace {

// Regions repeat the names of their set and material: without a bound they would take far more than
// the file.
constexpr std::size_t kLongestName = 256;

// A count of items that take at least `bytes` each, none below `lowest`.
Status read_count(ByteScanner& input, std::string_view what, std::size_t bytes, std::int32_t lowest,
                  std::size_t& count) {
  std::int32_t value = 0;
  if (!input.read(value, what)) return input.error();
  if (value < lowest)
    return input.problem("expected " + std::string(what) + ", at least " + std::to_string(lowest) +
                         ", found " + std::to_string(value));
  count = value;
  if (!input.fits(count - lowest, bytes, what)) return input.error();
  return Success{};
}

Status read_name(ByteScanner& input, std::string_view what, std::string& name) {
  std::size_t length = 0;
  if (Status status = read_count(input, what, 1, 0, length); !status) return status;
  if (length > kLongestName)
    return input.problem("expected " + std::string(what) + " of at most " +
                         std::to_string(kLongestName) + " characters, found " +
                         std::to_string(length));
  name.resize(length);
  for (char& c : name)
    if (!input.read(c, what)) return input.error();
  return Success{};
}

Status read_start(ByteScanner& input) {
  double version = 0;
  std::int32_t type = 0;
  if (!input.read(version, "the version")) return input.error();
  if (version != 1.0) return input.problem("expected version 1 of .vegb, found another");
  if (!input.read(type, "the element type")) return input.error();
  if (type != 1)
    return input.problem("expected element type 1, tetrahedra, found " + std::to_string(type) +
                         (type == 2 ? ", cubes" : ""));
  return Success{};
}

Status read_vertices(ByteScanner& input, MeshBuilder& builder) {
  std::size_t count = 0;
  if (Status status = read_count(input, "a number of vertices", 24, 0, count); !status)
    return status;
  builder.reserve_vertices(count);
  for (std::size_t v = 0; v < count; ++v) {
    Eigen::Vector3d x;
    for (double& coordinate : x)
      if (!input.read(coordinate, "a coordinate")) return input.error();
    if (!builder.add_vertex(v, x)) return input.problem(builder.complaint());
  }
  if (!builder.seal_vertices()) return input.problem(builder.complaint());
  return Success{};
}

Status read_elements(ByteScanner& input, MeshBuilder& builder) {
  std::size_t count = 0;
  std::int32_t nodes_of_one = 0;
  // The number of nodes is stored between the count and the elements.
  if (Status status = read_count(input, "a number of elements", 0, 0, count); !status)
    return status;
  if (!input.read(nodes_of_one, "4 nodes of an element")) return input.error();
  if (nodes_of_one != 4)
    return input.problem("expected linear tetrahedra of 4 nodes, found " +
                         std::to_string(nodes_of_one) + " nodes");
  if (!input.fits(count, 16, "elements")) return input.error();
  builder.reserve_tetrahedra(count);
  constexpr CellKind kKind{"tetrahedra", 4, CellKind::Role::kTetrahedron};
  std::vector<std::int64_t> nodes(4);
  std::vector<VertexId> vertices;
  for (std::size_t e = 0; e < count; ++e) {
    for (std::int64_t& node : nodes) {
      std::int32_t id = 0;
      if (!input.read(id, "a node of an element")) return input.error();
      node = id;
    }
    const std::int64_t id = e;
    if (!builder.resolve(id, nodes, vertices) || !builder.add_cell(id, kKind, vertices))
      return input.problem(builder.complaint());
  }
  return Success{};
}

// Kind and properties are those of a .veg file; errors in them matter only if the material is used.
Status read_materials(ByteScanner& input, VegRegions& regions) {
  std::size_t count = 0;
  if (Status status = read_count(input, "a number of materials", 8, 0, count); !status)
    return status;
  for (std::size_t m = 0; m < count; ++m) {
    FileMaterial found;
    std::int32_t type = 0;
    if (Status status = read_name(input, "the name of a material", found.region); !status)
      return status;
    if (!input.read(type, "the type of a material")) return input.error();
    if (type < 1 || type > 3)
      return input.problem("expected a material of type 1, 2 or 3, found " + std::to_string(type) +
                           " (" + quoted_text(found.region) + ")");
    constexpr const char* kKinds[] = {"ENU", "ORTHOTROPIC", "MOONEYRIVLIN"};
    constexpr std::size_t kProperties[] = {3, 19, 4};
    double properties[19];
    for (std::size_t p = 0; p < kProperties[type - 1]; ++p)
      if (!input.read(properties[p], "a property of a material")) return input.error();
    Result<Material> material = veg_material(kKinds[type - 1], {properties, kProperties[type - 1]});
    if (material)
      found.material = *material;
    else
      found.problem = input.problem(material.error().message).message;
    regions.materials.push_back(std::move(found));
  }
  return Success{};
}

Status read_set(ByteScanner& input, MeshBuilder& builder, VegRegions& regions,
                std::vector<std::string>& names) {
  std::string name;
  std::size_t count = 0;
  if (Status status = read_name(input, "the name of a set", name); !status) return status;
  if (Status status = read_count(input, "a number of elements of a set", 4, 0, count); !status)
    return status;
  const std::vector<Tetrahedron>& tets = builder.mesh().tetrahedra;
  std::vector<std::int32_t>& elements = regions.sets[name];
  names.push_back(name);
  std::vector<VertexId> vertices;
  for (std::size_t i = 0; i < count; ++i) {
    std::int32_t id = 0;
    if (!input.read(id, "an element of a set")) return input.error();
    if (!is_index(id, tets.size()))
      return input.problem("set " + quoted_text(name) + " names element " + std::to_string(id) +
                           ", expected one below " + std::to_string(tets.size()));
    const Tetrahedron& tet = tets[id];
    vertices.insert(vertices.end(), tet.begin(), tet.end());
    elements.push_back(id);
  }
  if (!vertices.empty()) builder.add_to_set(name, vertices);
  return Success{};
}

// sets: names; the first is of all elements.
Status read_regions(ByteScanner& input, const std::vector<std::string>& sets, VegRegions& regions) {
  std::size_t count = 0;
  if (Status status = read_count(input, "a number of regions", 8, 0, count); !status) return status;
  for (std::size_t n = 0; n < count; ++n) {
    std::size_t ids[2] = {};
    std::size_t* at = ids;
    for (const auto& [what, limit] :
         {std::pair{"material", regions.materials.size()}, {"set", sets.size()}}) {
      std::int32_t id = 0;
      if (!input.read(id, what)) return input.error();
      if (!is_index(id, limit))
        return input.problem("region " + std::to_string(n) + " names " + what + " " +
                             std::to_string(id) + ", expected one below " + std::to_string(limit));
      *at++ = id;
    }
    regions.regions.emplace_back(sets[ids[1]], regions.materials[ids[0]].region);
  }
  return Success{};
}

}  // namespace

Result<MeshFile> read_vegb(std::string_view bytes, const std::string& path) {
  ByteScanner input(bytes, path, 0, kSwapsLittleEndian);
  MeshBuilder builder(path);
  VegRegions regions;
  std::vector<std::string> names{"allElements"};
  std::size_t sets = 0;
  Status status = read_start(input);
  if (status) status = read_vertices(input, builder);
  if (status) status = read_elements(input, builder);
  if (status) status = read_materials(input, regions);
  if (status) status = read_count(input, "a number of sets", 8, 1, sets);
  for (std::size_t set = 1; status && set < sets; ++set)
    status = read_set(input, builder, regions, names);
  if (status) status = read_regions(input, names, regions);
  if (!status) return status.error();
  if (input.remaining() > 0)
    return input.problem("expected the end of the file behind the regions, found " +
                         std::to_string(input.remaining()) + " more bytes");
  set_veg_regions(regions, builder);
  return builder.finish("VegaFEM binary");
}

}  // namespace tremolo
