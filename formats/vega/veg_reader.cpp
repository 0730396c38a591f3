#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "formats/mesh/mesh_builder.h"
#include "formats/mesh/mesh_reader.h"
#include "formats/vega/veg_input.h"
#include "formats/vega/veg_regions.h"

namespace tremolo {
namespace {

struct VegFile {
  MeshBuilder builder;
  std::int64_t first_element = 0;  // id of the first: 0 or 1
  bool has_vertices = false;
  bool has_elements = false;
  VegRegions regions;
};

// The number of items of `bytes` each that this file can hold. The given count may be wrong, and
// the items may be in an included file.
std::size_t at_most(VegInput& input, std::uint64_t count, std::size_t bytes) {
  return std::min<std::size_t>(count, input.line().remaining() / bytes);
}

Status read_vertices(VegInput& input, VegFile& file) {
  std::uint64_t count = 0;
  int dimension = 3;
  if (file.has_vertices)
    return input.line().problem("expected one section *VERTICES, found a second");
  file.has_vertices = true;
  if (!input.expect_line("the number of vertices") ||
      !input.line().read(count, "the number of vertices"))
    return input.error();
  if (!input.line().at_line_end() && !input.line().read(dimension, "the dimension 3"))
    return input.error();
  if (dimension != 3)
    return input.line().problem("expected dimension 3, found " + std::to_string(dimension));
  file.builder.reserve_vertices(at_most(input, count, 8));
  for (std::uint64_t n = 0; n < count; ++n) {
    std::int64_t id = 0;
    Eigen::Vector3d x;
    if (!input.expect_line("a vertex") || !input.line().read(id, "a vertex id"))
      return input.error();
    for (double& coordinate : x)
      if (!input.line().read(coordinate, "a coordinate")) return input.error();
    if (!file.builder.add_vertex(id, x)) return input.line().problem(file.builder.complaint());
  }
  if (!file.builder.seal_vertices()) return input.line().problem(file.builder.complaint());
  return Success{};
}

Status read_element_header(VegInput& input, std::uint64_t& count) {
  std::string kind;
  int nodes = 4;
  if (!input.expect_line("TETS") || !input.line().read_word(kind, "TETS")) return input.error();
  if (kind != "TET" && kind != "TETS")
    return input.line().problem("expected TETS, found " + quoted_text(kind));
  if (!input.expect_line("the number of elements") ||
      !input.line().read(count, "the number of elements"))
    return input.error();
  if (!input.line().at_line_end() && !input.line().read(nodes, "4 nodes of an element"))
    return input.error();
  if (nodes != 4)
    return input.line().problem("expected linear tetrahedra of 4 nodes, found " +
                                std::to_string(nodes) + " nodes");
  return Success{};
}

Status read_elements(VegInput& input, VegFile& file) {
  if (!file.has_vertices || file.has_elements)
    return input.line().problem("expected one section *ELEMENTS behind *VERTICES, found " +
                                std::string(file.has_elements ? "a second" : "it before"));
  file.has_elements = true;
  std::uint64_t count = 0;
  Status header = read_element_header(input, count);
  if (!header) return header;
  file.builder.reserve_tetrahedra(at_most(input, count, 10));
  constexpr CellKind kKind{"tetrahedra", 4, CellKind::Role::kTetrahedron};
  std::vector<std::int64_t> nodes(4);
  std::vector<VertexId> vertices;
  for (std::uint64_t e = 0; e < count; ++e) {
    std::int64_t id = 0;
    if (!input.expect_line("an element") || !input.line().read(id, "an element id"))
      return input.error();
    // Sets refer to elements by their position, so the ids must agree with it.
    if (e == 0) file.first_element = id;
    const std::int64_t expected = file.first_element + e;
    if ((id != 0 && id != 1 && e == 0) || id != expected)
      return input.line().problem("expected element id " +
                                  (e == 0 ? "0 or 1" : std::to_string(expected)) + ", found " +
                                  std::to_string(id));
    for (std::int64_t& node : nodes)
      if (!input.line().read(node, "a node of an element")) return input.error();
    if (!file.builder.resolve(id, nodes, vertices) || !file.builder.add_cell(id, kKind, vertices))
      return input.line().problem(file.builder.complaint());
  }
  return Success{};
}

// A set lists elements; its node set holds their vertices. Stops at the line of the next keyword.
Result<bool> read_set(VegInput& input, VegFile& file) {
  std::string name;
  if (!input.line().read_word(name, "the name of a set")) return input.error();
  const std::vector<Tetrahedron>& tets = file.builder.mesh().tetrahedra;
  const std::int64_t count = tets.size();
  std::vector<std::int32_t>& elements = file.regions.sets[name];
  std::vector<VertexId> vertices;
  bool more = input.next_line();
  for (; more && !input.line().peek().starts_with('*'); more = input.next_line()) {
    while (!input.line().at_line_end()) {
      std::int64_t id = 0;
      if (!input.line().read(id, "an element id")) return input.error();
      if (id < file.first_element || id - file.first_element >= count)
        return input.line().problem("set " + quoted_text(name) + " names element " +
                                    std::to_string(id) + ", expected an id from " +
                                    std::to_string(file.first_element) + " to " +
                                    std::to_string(file.first_element + count - 1));
      const std::int64_t element = id - file.first_element;
      const Tetrahedron& tet = tets[element];
      vertices.insert(vertices.end(), tet.begin(), tet.end());
      elements.push_back(static_cast<std::int32_t>(element));
    }
  }
  if (!vertices.empty()) file.builder.add_to_set(name, vertices);
  return more;
}

// Goes to the line of the next keyword.
bool skip_rows(VegInput& input, bool more) {
  while (more && !input.line().peek().starts_with('*')) more = input.next_line();
  return more;
}

// The rest of a line without its blanks: VegaFEM takes them out of names.
std::string joined_rest(VegInput& input) {
  std::string text;
  while (!input.line().at_line_end()) text += input.line().token();
  return text;
}

// Reads kind and numbers of a material on one line. Errors in it matter only if the material is
// used.
Result<bool> read_material(VegInput& input, VegFile& file) {
  FileMaterial found;
  found.region = joined_rest(input);
  const bool more = input.next_line();
  if (!more || input.line().peek().starts_with('*')) {
    found.problem = input.line().problem("expected a material's constants").message;
  } else {
    const std::string kind(input.line().token());
    std::vector<double> numbers;
    bool good = true;
    while (good && !input.line().at_line_end()) {
      double number = 0;
      good = input.line().read(number, "a number of a material");
      numbers.push_back(number);
    }
    Result<Material> material = veg_material(kind, numbers);
    if (!good)
      found.problem = input.line().error().message;
    else if (!material)
      found.problem = input.line().problem(material.error().message).message;
    else
      found.material = *material;
  }
  file.regions.materials.push_back(std::move(found));
  return skip_rows(input, more);
}

// A set and the material of its elements.
Result<bool> read_region(VegInput& input, VegFile& file) {
  const bool more = input.next_line();
  if (more && !input.line().peek().starts_with('*')) {
    std::string set(input.line().token());
    file.regions.regions.emplace_back(std::move(set), joined_rest(input));
  }
  return skip_rows(input, more);
}

Result<bool> read_section(VegInput& input, VegFile& file) {
  const std::string keyword(input.line().token());
  if (keyword == "*VERTICES" || keyword == "*ELEMENTS") {
    const Status status =
        keyword == "*VERTICES" ? read_vertices(input, file) : read_elements(input, file);
    if (!status) return status.error();
    return input.next_line();
  }
  if (keyword == "*SET") return read_set(input, file);
  if (keyword != "*MATERIAL" && keyword != "*REGION")
    return input.line().problem(
        "expected *VERTICES, *ELEMENTS, *SET, *MATERIAL, *REGION or "
        "*INCLUDE, found " +
        quoted_text(keyword));
  return keyword == "*MATERIAL" ? read_material(input, file) : read_region(input, file);
}

}  // namespace

Result<MeshFile> read_veg(std::string_view text, const std::string& path) {
  VegInput input(text, path);
  VegFile file{MeshBuilder(path), 0, false, false, {}};
  for (Result<bool> more = input.next_line(); *more;) {
    more = read_section(input, file);
    if (!more) return more.error();
  }
  if (input.failed()) return input.error();
  if (!file.has_elements) {
    input.line().fail(file.has_vertices ? "*ELEMENTS" : "*VERTICES", "");
    return input.error();
  }
  set_veg_regions(file.regions, file.builder);
  return file.builder.finish("VegaFEM");
}

}  // namespace tremolo
