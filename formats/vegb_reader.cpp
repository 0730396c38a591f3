// VegaFEM's binary mesh, .vegb. Little-endian; a text is i32 length and so many characters.
//
//   f64 version 1, i32 element type (1 tetrahedra, 2 cubes)
//   i32 vertices, f64 x y z each
//   i32 elements, i32 nodes of one, i32 vertices from 0 each
//   i32 materials; each: text name, i32 type, f64 properties: 1 E-nu: density, E, nu;
//       2 orthotropic: density, 3 E, 3 nu, 3 G and a rotation of 9; 3 Mooney-Rivlin: 4
//   i32 sets, of which the first, all elements, is not stored; each: text name, i32 count, i32
//       elements from 0
//   i32 regions; each: i32 material, i32 set
#include <bit>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "formats/byte_scanner.h"
#include "formats/mesh_builder.h"
#include "formats/mesh_formats.h"
#include "formats/text_scanner.h"
#include "formats/veg_material.h"

namespace tremolo {
namespace {

constexpr bool kSwap = std::endian::native != std::endian::little;

// A count of items that take at least `bytes` each, none below `lowest`.
Status read_count(ByteScanner& input, std::string_view what, std::size_t bytes, std::int32_t lowest,
                  std::size_t& count) {
  std::int32_t value = 0;
  if (!input.read(value, what)) return input.error();
  if (value < lowest)
    return input.problem("expected " + std::string(what) + ", at least " + std::to_string(lowest) +
                         ", found " + std::to_string(value));
  count = static_cast<std::size_t>(value);
  if (!input.fits(count - static_cast<std::size_t>(lowest), bytes, what)) return input.error();
  return Success{};
}

Status read_name(ByteScanner& input, std::string_view what, std::string& name) {
  std::size_t length = 0;
  if (Status status = read_count(input, what, 1, 0, length); !status) return status;
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
    if (!builder.add_vertex(static_cast<std::int64_t>(v), x))
      return input.problem(builder.complaint());
  }
  if (!builder.seal_vertices()) return input.problem(builder.complaint());
  return Success{};
}

Status read_elements(ByteScanner& input, MeshBuilder& builder) {
  std::size_t count = 0;
  std::int32_t nodes_of_one = 0;
  // The number of nodes stands between the count and the elements.
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
    const auto id = static_cast<std::int64_t>(e);
    if (!builder.resolve(id, nodes, vertices) || !builder.add_cell(id, kKind, vertices))
      return input.problem(builder.complaint());
  }
  return Success{};
}

// What the regions refer to by number. sets: elements; the first, all of them, is left empty.
struct VegbTables {
  std::vector<FileMaterial> materials;
  std::vector<std::vector<std::int32_t>> sets{1};
  std::vector<std::pair<std::size_t, std::size_t>> regions;  // material, set
};

Status read_material(ByteScanner& input, std::set<std::string>& names, FileMaterial& found) {
  if (Status status = read_name(input, "the name of a material", found.region); !status)
    return status;
  // Regions of the mesh go by name.
  if (!names.insert(found.region).second)
    return input.problem("expected a material's name that no other has, found " +
                         quoted_text(found.region) + " a second time");
  std::int32_t type = 0;
  if (!input.read(type, "the type of a material")) return input.error();
  if (type < 1 || type > 3)
    return input.problem("expected a material of type 1, 2 or 3, found " + std::to_string(type) +
                         " (" + quoted_text(found.region) + ")");
  constexpr std::pair<std::string_view, std::size_t> kKinds[] = {
      {"ENU", 3}, {"ORTHOTROPIC", 19}, {"MOONEYRIVLIN", 4}};
  const auto& [kind, count] = kKinds[type - 1];
  std::vector<double> numbers(count);
  for (double& number : numbers)
    if (!input.read(number, "a number of a material")) return input.error();
  // What is wrong with it matters only to who wants it.
  const Result<Material> material = veg_material(kind, numbers);
  if (material)
    found.material = *material;
  else
    found.problem = input.problem(material.error().message).message;
  return Success{};
}

Status read_materials(ByteScanner& input, VegbTables& tables) {
  std::size_t count = 0;
  std::set<std::string> names;
  if (Status status = read_count(input, "a number of materials", 8, 0, count); !status)
    return status;
  for (std::size_t m = 0; m < count; ++m) {
    FileMaterial found;
    if (Status status = read_material(input, names, found); !status) return status;
    tables.materials.push_back(std::move(found));
  }
  return Success{};
}

Status read_set(ByteScanner& input, MeshBuilder& builder, std::vector<std::int32_t>& elements) {
  std::string name;
  std::size_t count = 0;
  if (Status status = read_name(input, "the name of a set", name); !status) return status;
  if (Status status = read_count(input, "a number of elements of a set", 4, 0, count); !status)
    return status;
  const std::vector<Tetrahedron>& tets = builder.mesh().tetrahedra;
  elements.resize(count);
  for (std::int32_t& id : elements) {
    if (!input.read(id, "an element of a set")) return input.error();
    if (id < 0 || static_cast<std::size_t>(id) >= tets.size())
      return input.problem("set " + quoted_text(name) + " names element " + std::to_string(id) +
                           ", expected one below " + std::to_string(tets.size()));
    builder.add_to_set(name, tets[static_cast<std::size_t>(id)]);
  }
  return Success{};
}

Status read_sets(ByteScanner& input, MeshBuilder& builder, VegbTables& tables) {
  std::size_t count = 0;
  if (Status status = read_count(input, "a number of sets", 8, 1, count); !status) return status;
  for (std::size_t set = 1; set < count; ++set) {
    tables.sets.emplace_back();
    if (Status status = read_set(input, builder, tables.sets.back()); !status) return status;
  }
  return Success{};
}

Status read_regions(ByteScanner& input, VegbTables& tables) {
  std::size_t count = 0;
  if (Status status = read_count(input, "a number of regions", 8, 0, count); !status) return status;
  const auto choose = [&](std::size_t region, const char* what, std::size_t limit,
                          std::size_t& chosen) -> Status {
    std::int32_t id = 0;
    if (!input.read(id, what)) return input.error();
    if (id < 0 || static_cast<std::size_t>(id) >= limit)
      return input.problem("region " + std::to_string(region) + " names " + what + " " +
                           std::to_string(id) + ", expected one below " + std::to_string(limit));
    chosen = static_cast<std::size_t>(id);
    return Success{};
  };
  tables.regions.resize(count);
  for (std::size_t n = 0; n < count; ++n) {
    auto& [material, set] = tables.regions[n];
    Status status = choose(n, "material", tables.materials.size(), material);
    if (status) status = choose(n, "set", tables.sets.size(), set);
    if (!status) return status;
  }
  return Success{};
}

// A region of the mesh is what has one material, and is called like it. As in VegaFEM, the last
// region that lists an element decides.
void set_regions(const VegbTables& tables, MeshBuilder& builder) {
  std::vector<std::int64_t> material_of(builder.mesh().tetrahedra.size(), -1);
  // From the last on, and of regions of one set the last alone: the work is bounded by the file.
  std::vector<bool> done(tables.sets.size(), false);
  for (auto region = tables.regions.rbegin(); region != tables.regions.rend(); ++region) {
    const auto label = static_cast<std::int64_t>(region->first);
    if (done[region->second]) continue;
    done[region->second] = true;
    const auto put = [&](std::size_t element) {
      if (material_of[element] < 0) material_of[element] = label;
    };
    if (region->second == 0)
      for (std::size_t element = 0; element < material_of.size(); ++element) put(element);
    else
      for (std::int32_t element : tables.sets[region->second])
        put(static_cast<std::size_t>(element));
  }
  for (const FileMaterial& material : tables.materials) builder.add_material(material);
  builder.set_regions(material_of, [&tables](std::int64_t label) {
    return label < 0 ? std::string() : tables.materials[static_cast<std::size_t>(label)].region;
  });
}

}  // namespace

Result<MeshFile> read_vegb(std::string_view bytes, const std::string& path) {
  ByteScanner input(bytes, path, 0, kSwap);
  MeshBuilder builder(path);
  VegbTables tables;
  Status status = read_start(input);
  if (status) status = read_vertices(input, builder);
  if (status) status = read_elements(input, builder);
  if (status) status = read_materials(input, tables);
  if (status) status = read_sets(input, builder, tables);
  if (status) status = read_regions(input, tables);
  if (!status) return status.error();
  if (input.remaining() > 0)
    return input.problem("expected the end of the file behind the regions, found " +
                         std::to_string(input.remaining()) + " more bytes");
  set_regions(tables, builder);
  return builder.finish("VegaFEM binary");
}

}  // namespace tremolo
