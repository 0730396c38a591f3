// Nastran bulk data: GRID, solid and shell elements, PSOLID, MAT1.
#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "formats/file/scanner.h"
#include "formats/mesh/mesh_builder.h"
#include "formats/mesh/mesh_reader.h"
#include "formats/nastran/bdf_cards.h"

namespace tremolo {
namespace {

using Role = CellKind::Role;

// An element card lists its nodes after id and property: all of `kind`, or only the corners.
struct BdfKind {
  std::string_view card;
  CellKind corners;
  CellKind all;
};
constexpr std::array<BdfKind, 11> kKinds = {
    {{"CTETRA",
      {"tetrahedra", 4, Role::kTetrahedron},
      {"10-node tetrahedra", 10, Role::kQuadraticTetrahedron}},
     {"CPYRAM", {"pyramids", 5, Role::kPyramid}, {"13-node pyramids", 13, Role::kPyramid}},
     {"CPYRA", {"pyramids", 5, Role::kPyramid}, {"13-node pyramids", 13, Role::kPyramid}},
     {"CPENTA", {"wedges", 6, Role::kWedge}, {"15-node wedges", 15, Role::kWedge}},
     {"CHEXA", {"hexahedra", 8, Role::kHexahedron}, {"20-node hexahedra", 20, Role::kHexahedron}},
     {"CTRIA3", {"triangles", 3}, {"triangles", 3}},
     {"CTRIAR", {"triangles", 3}, {"triangles", 3}},
     {"CQUAD4", {"quadrangles", 4}, {"quadrangles", 4}},
     {"CQUADR", {"quadrangles", 4}, {"quadrangles", 4}},
     {"CTRIA6", {"6-node triangles", 6}, {"6-node triangles", 6}},
     {"CQUAD8", {"8-node quadrangles", 8}, {"8-node quadrangles", 8}}}};

struct BdfElement {
  std::int64_t id = 0;
  std::int64_t property = 0;
  const CellKind* kind = nullptr;
  std::size_t first_node = 0;
  std::size_t line = 0;
};

struct BdfMaterial {
  Material material;
  std::string problem;
};

// Cards may be in any order: they are collected first.
struct BdfFile {
  MeshBuilder builder;
  std::vector<BdfElement> elements;
  std::vector<std::int64_t> nodes;
  std::vector<BdfSet> sets;
  std::map<std::int64_t, std::int64_t> material_of_property;
  std::map<std::int64_t, BdfMaterial> materials;
  std::map<std::string, std::size_t> skipped;  // element cards, by name
};

std::string property_name(std::int64_t property) {
  return "PID " + std::to_string(property);
}

Status expected(const BdfCards& cards, const BdfCard& card, const std::string& what,
                std::string_view found) {
  return cards.problem(card.line, card.name + ": expected " + what + ", found " +
                                      (found.empty() ? "an empty field" : quoted_text(found)));
}

Status read_grid(const BdfCards& cards, const BdfCard& card, BdfFile& file) {
  const auto id = bdf_integer(card.field(0));
  if (!id) return expected(cards, card, "the id of a point", card.field(0));
  const std::string_view system = card.field(1);
  if (!system.empty() && bdf_integer(system) != 0)
    return expected(cards, card,
                    "a point in the basic coordinate system (CP 0): write the mesh in that",
                    system);
  Eigen::Vector3d x;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string_view field = card.field(2 + axis);
    const auto value = field.empty() ? std::optional<double>(0) : bdf_real(field);
    if (!value) return expected(cards, card, "a coordinate", field);
    x[axis] = *value;
  }
  if (!file.builder.add_vertex(*id, x)) return cards.problem(card.line, file.builder.complaint());
  return Success{};
}

Status read_element(const BdfCards& cards, const BdfCard& card, const BdfKind& kind,
                    BdfFile& file) {
  BdfElement element{0, 0, &kind.corners, file.nodes.size(), card.line};
  const auto id = bdf_integer(card.field(0));
  if (!id) return expected(cards, card, "the id of an element", card.field(0));
  element.id = *id;
  // Without a property it is that of the element's own number.
  const auto property = card.field(1).empty() ? id : bdf_integer(card.field(1));
  if (!property) return expected(cards, card, "the id of a property", card.field(1));
  element.property = *property;
  const auto filled = [&](std::size_t first, std::size_t end) {
    std::size_t count = 0;
    for (std::size_t n = first; n < end; ++n) count += card.field(2 + n).empty() ? 0 : 1;
    return count;
  };
  const std::size_t corners = kind.corners.nodes;
  const std::size_t all = kind.all.nodes;
  const std::size_t middles = filled(corners, all);
  if (middles > 0 && (middles == all - corners || kind.all.is_cut())) element.kind = &kind.all;
  if (middles > 0 && element.kind == &kind.corners)
    return expected(cards, card, std::to_string(corners) + " or " + std::to_string(all) + " nodes",
                    std::to_string(corners + middles));
  // Solids that are cut by their corners may lack some of the others.
  const std::size_t used = element.kind->is_cut() ? corners : element.kind->nodes;
  for (std::size_t n = 0; n < used; ++n) {
    const auto node = bdf_integer(card.field(2 + n));
    if (!node) return expected(cards, card, "the id of a point", card.field(2 + n));
    file.nodes.push_back(*node);
  }
  file.elements.push_back(element);
  return Success{};
}

// MAT1: E, G, NU, RHO, of which one of the first three may be left out.
void read_material(const BdfCard& card, BdfFile& file) {
  const auto id = bdf_integer(card.field(0));
  if (!id) return;
  const auto young = bdf_real(card.field(1));
  const auto shear = bdf_real(card.field(2));
  auto poisson = bdf_real(card.field(3));
  const auto density = bdf_real(card.field(4));
  if (!poisson && young && shear && *shear != 0) poisson = *young / (2 * *shear) - 1;
  BdfMaterial material;
  if (!young || !poisson)
    material.problem = "its MAT1 has no E and NU";
  else if (!density)
    material.problem = "its MAT1 has no RHO";
  else
    material.material = {*young, *poisson, *density};
  file.materials[*id] = material;
}

Status read_card(const BdfCards& cards, const BdfCard& card, BdfFile& file) {
  if (card.name == "GRID") return read_grid(cards, card, file);
  for (const BdfKind& kind : kKinds)
    if (card.name == kind.card) return read_element(cards, card, kind, file);
  if (card.name == "GRDSET" && !card.field(1).empty() && bdf_integer(card.field(1)) != 0)
    return expected(cards, card, "the basic coordinate system (CP 0)", card.field(1));
  if (card.name == "MAT1") read_material(card, file);
  if (card.name == "PSOLID") {
    const auto property = bdf_integer(card.field(0));
    const auto material = bdf_integer(card.field(1));
    if (property && material) file.material_of_property[*property] = *material;
  }
  if (card.name == "CBAR" || card.name == "CBEAM" || card.name == "CROD" || card.name == "CONM2" ||
      card.name == "RBE2" || card.name == "RBE3")
    ++file.skipped[card.name];
  return Success{};
}

Status add_elements(const BdfCards& cards, BdfFile& file) {
  if (!file.builder.seal_vertices()) return cards.problem(1, file.builder.complaint());
  std::vector<VertexId> vertices;
  std::vector<std::int64_t> property_of_tet;
  for (const BdfElement& element : file.elements) {
    const std::size_t count =
        element.kind->is_cut() ? element.kind->corners() : element.kind->nodes;
    if (!file.builder.resolve(element.id, {file.nodes.data() + element.first_node, count},
                              vertices) ||
        !file.builder.add_cell(element.id, *element.kind, vertices, true))
      return cards.problem(element.line, file.builder.complaint());
    file.builder.add_to_set(property_name(element.property), vertices);
    property_of_tet.resize(file.builder.mesh().tetrahedra.size(), element.property);
  }
  file.builder.set_regions(property_of_tet, property_name);
  for (const auto& [property, id] : file.material_of_property)
    if (const auto found = file.materials.find(id); found != file.materials.end())
      file.builder.add_material(
          {property_name(property), found->second.material, found->second.problem});
  return Success{};
}

using Members = std::vector<std::pair<std::int64_t, std::size_t>>;  // ids and their indices

// The members of `table`, ascending, in a set. Overlapping ranges give some twice.
std::vector<std::size_t> members_of(const BdfSet& set, const Members& table) {
  std::vector<bool> taken(table.size(), false);
  for (const auto& [first, last] : set.ranges) {
    auto at = std::lower_bound(table.begin(), table.end(), std::pair(first, std::size_t{0}));
    for (; at != table.end() && at->first <= last; ++at) taken[at - table.begin()] = true;
  }
  std::vector<std::size_t> members;
  for (std::size_t n = 0; n < table.size(); ++n)
    if (taken[n]) members.push_back(table[n].second);
  return members;
}

// A set has ids of points or of elements, which its use says: here of points if it finds as many of
// them as of elements. Sets of one file have at most 64 members a byte together.
Status add_sets(const BdfCards& cards, std::size_t bytes, const std::vector<std::int64_t>& ids,
                BdfFile& file) {
  Members points, elements;
  for (std::size_t n = 0; n < ids.size(); ++n) points.emplace_back(ids[n], n);
  for (std::size_t n = 0; n < file.elements.size(); ++n)
    elements.emplace_back(file.elements[n].id, n);
  std::sort(points.begin(), points.end());
  std::sort(elements.begin(), elements.end());
  std::size_t members = 0;
  for (const BdfSet& set : file.sets) {
    const std::string name = "SET " + std::to_string(set.id);
    const std::vector<std::size_t> of_points = members_of(set, points);
    const std::vector<std::size_t> of_elements = members_of(set, elements);
    std::vector<VertexId> vertices(of_points.begin(), of_points.end());
    if (of_elements.size() > of_points.size()) {
      vertices.clear();
      for (const std::size_t e : of_elements) {
        const BdfElement& element = file.elements[e];
        std::vector<VertexId> nodes;
        const std::size_t count =
            element.kind->is_cut() ? element.kind->corners() : element.kind->nodes;
        if (!file.builder.resolve(element.id, {file.nodes.data() + element.first_node, count},
                                  nodes))
          return cards.problem(element.line, file.builder.complaint());
        vertices.insert(vertices.end(), nodes.begin(), nodes.end());
      }
    }
    members += vertices.size();
    if (members > 16 * bytes)
      return cards.problem(1, "expected sets of at most " + std::to_string(16 * bytes) +
                                  " members together in a file of this size, found more");
    file.builder.add_to_set(name, vertices);
  }
  return Success{};
}

}  // namespace

Result<MeshFile> read_bdf(std::string_view text, const std::string& path) {
  BdfCards cards(text, path);
  BdfFile file{MeshBuilder(path), {}, {}, {}, {}, {}, {}};
  Status status = cards.read_case_control(file.sets);
  if (!status) return status.error();
  BdfCard card;
  std::vector<std::int64_t> ids;
  while (cards.next(card)) {
    status = read_card(cards, card, file);
    if (!status) return status.error();
    if (card.name == "GRID") ids.push_back(*bdf_integer(card.field(0)));
  }
  if (cards.failed()) return cards.error();
  if (!cards.ended())
    return content_error(path +
                         ": expected ENDDATA at the end of the cards, found the end of the file, "
                         "which may be cut off");
  status = add_elements(cards, file);
  if (status) status = add_sets(cards, text.size(), ids, file);
  if (!status) return status.error();
  for (const auto& [name, count] : file.skipped)
    file.builder.add_note(std::to_string(count) + " cards " + name + " skipped");
  return file.builder.finish("Nastran");
}

}  // namespace tremolo
