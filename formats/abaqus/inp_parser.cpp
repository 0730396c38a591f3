#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

#include "common/text.h"
#include "formats/abaqus/inp_model.h"

namespace tremolo {
namespace {

using Role = CellKind::Role;

struct InpKind {
  int nodes;
  CellKind kind;
};
// Solids by their number of nodes; letters after it (C3D8R, C3D10MH) select an integration.
constexpr std::array<InpKind, 8> kSolids = {
    {{4, {"tetrahedra", 4, Role::kTetrahedron}},
     {10, {"10-node tetrahedra", 10, Role::kQuadraticTetrahedron}},
     {5, {"pyramids", 5, Role::kPyramid}},
     {6, {"wedges", 6, Role::kWedge}},
     {8, {"hexahedra", 8, Role::kHexahedron}},
     {13, {"13-node pyramids", 13, Role::kPyramid}},
     {15, {"15-node wedges", 15, Role::kWedge}},
     {20, {"20-node hexahedra", 20, Role::kHexahedron}}}};
constexpr CellKind kOtherElements{"elements that are no solids", 0, Role::kOther};

constexpr std::pair<std::string_view, std::string_view> kRefused[] = {
    {"NGEN", "write the nodes out"},
    {"NFILL", "write the nodes out"},
    {"NCOPY", "write the nodes out"},
    {"NMAP", "write the nodes out"},
    {"ELGEN", "write the elements out"},
    {"ELCOPY", "write the elements out"},
    {"SYSTEM", "write the nodes in the global coordinate system"}};

// One file while it is read.
struct InpParser {
  explicit InpParser(InpInput source) : input(std::move(source)) {}

  InpInput input;
  InpModel model;
  InpPart* part = nullptr;  // the target of nodes and elements
  std::string material;     // upper case, of the *MATERIAL above
  std::size_t members = 0;  // of all sets
  std::size_t sets = 0;

  // Sets have so many ids together, since a set may list another, or all from 1 to 10^9.
  std::size_t most_members() const { return 4 * input.bytes(); }

  Status fail(const std::string& text) const { return input.problem(text); }
  Status scan_error() { return input.error(); }
};

InpSet& set_named(InpParser& parser, InpSets& sets, const std::string& name) {
  InpSet& set = sets[upper_case(name)];
  if (set.name.empty()) set.name = name;
  set.order = ++parser.sets;
  return set;
}

Status add_member(InpParser& parser, InpSet& set, std::int64_t id) {
  if (++parser.members > parser.most_members())
    return parser.fail("expected sets of at most " + std::to_string(parser.most_members()) +
                       " nodes and elements together in a file of this size, found more");
  set.ids.push_back(id);
  return Success{};
}

Status read_nodes(InpParser& parser, const InpKeyword& keyword) {
  const std::string system = upper_case(keyword.value("SYSTEM"));
  if (!system.empty() && system != "R")
    return parser.fail("expected nodes in rectangular coordinates, found SYSTEM=" + system +
                       ": write them in x, y, z");
  if (keyword.has("INPUT") && !parser.input.include(keyword.value("INPUT")))
    return parser.scan_error();
  InpSet* set = nullptr;
  if (keyword.has("NSET")) set = &set_named(parser, parser.part->node_sets, keyword.value("NSET"));
  while (parser.input.next_data()) {
    std::int64_t id = 0;
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    TextScanner& line = parser.input.line();
    if (!line.read(id, "a node id")) return parser.scan_error();
    // Coordinates at the end of the line that are left out are zero.
    for (int axis = 0; axis < 3; ++axis)
      if (!line.at_line_end() && !line.read(x[axis], "a coordinate")) return parser.scan_error();
    parser.part->node_ids.push_back(id);
    parser.part->nodes.push_back(x);
    const Status status = set != nullptr ? add_member(parser, *set, id) : Success{};
    if (!status) return status;
  }
  return Success{};
}

// nullptr: a solid whose number of nodes is unknown.
const CellKind* kind_of_type(const std::string& type) {
  const std::size_t at = type.find("C3D");
  if (at == std::string::npos || at > 2) return &kOtherElements;
  int nodes = 0;
  const char* first = type.data() + at + 3;
  const auto [end, code] = std::from_chars(first, type.data() + type.size(), nodes);
  if (code != std::errc{}) return nullptr;
  for (const InpKind& solid : kSolids)
    if (solid.nodes == nodes) return &solid.kind;
  return nullptr;
}

Status read_elements(InpParser& parser, const InpKeyword& keyword) {
  const std::string type = upper_case(keyword.value("TYPE"));
  const CellKind* kind = kind_of_type(type);
  if (kind == nullptr)
    return parser.fail("expected C3D4, C3D10, C3D5, C3D6, C3D8, C3D15 or C3D20, found TYPE=" +
                       type);
  if (keyword.has("INPUT") && !parser.input.include(keyword.value("INPUT")))
    return parser.scan_error();
  InpSet* set = nullptr;
  if (keyword.has("ELSET"))
    set = &set_named(parser, parser.part->element_sets, keyword.value("ELSET"));
  InpPart& part = *parser.part;
  const std::size_t expected = kind->nodes;
  while (parser.input.next_data()) {
    InpElement element{0, kind, part.element_nodes.size(), 0};
    bool more = parser.input.continues();
    if (!parser.input.line().read(element.id, "an element id")) return parser.scan_error();
    for (;;) {
      while (!parser.input.line().at_line_end() &&
             (expected == 0 || element.node_count < expected)) {
        std::int64_t node = 0;
        if (!parser.input.line().read(node, "a node of an element")) return parser.scan_error();
        part.element_nodes.push_back(node);
        ++element.node_count;
      }
      if (expected == 0 ? !more : element.node_count == expected) break;
      if (!parser.input.next_data())
        return parser.fail("element " + std::to_string(element.id) + " of type " + type +
                           ": expected " + std::to_string(expected) + " nodes, found " +
                           std::to_string(element.node_count));
      more = parser.input.continues();
    }
    part.elements.push_back(element);
    const Status status = set != nullptr ? add_member(parser, *set, element.id) : Success{};
    if (!status) return status;
  }
  return Success{};
}

// first, last and step of a line of GENERATE.
Status read_range(InpParser& parser, InpSet& set) {
  TextScanner& line = parser.input.line();
  std::int64_t first = 0;
  std::int64_t last = 0;
  std::int64_t step = 1;
  if (!line.read(first, "the first id") || !line.read(last, "the last id") ||
      (!line.at_line_end() && !line.read(step, "the step between ids")))
    return parser.scan_error();
  if (step < 1 || first < 0 || last < first)
    return parser.fail("expected ids from 0 on that ascend, found " + std::to_string(first) +
                       " to " + std::to_string(last) + " by " + std::to_string(step));
  for (std::int64_t id = first;; id += step) {
    const Status status = add_member(parser, set, id);
    if (!status) return status;
    if (id > last - step) return Success{};
  }
}

// Ids, and names of sets that are already there.
Status read_members(InpParser& parser, const InpSets& known, InpSet& set) {
  TextScanner& line = parser.input.line();
  while (!line.at_line_end()) {
    const std::string_view token = line.peek();
    std::int64_t id = 0;
    const auto [end, code] = std::from_chars(token.data(), token.data() + token.size(), id);
    if (code == std::errc{} && end == token.data() + token.size()) {
      if (!line.read(id, "an id")) return parser.scan_error();
      const Status status = add_member(parser, set, id);
      if (!status) return status;
      continue;
    }
    const auto found = known.find(upper_case(token));
    line.token();
    if (found == known.end())
      return parser.fail("expected an id or the name of a set above, found " + quoted_text(token));
    const std::vector<std::int64_t> ids = found->second.ids;
    for (const std::int64_t member : ids) {
      const Status status = add_member(parser, set, member);
      if (!status) return status;
    }
  }
  return Success{};
}

Status read_set(InpParser& parser, const InpKeyword& keyword, bool of_nodes) {
  const std::string parameter = of_nodes ? "NSET" : "ELSET";
  const std::string name = keyword.value(parameter);
  if (name.empty())
    return parser.fail("expected " + parameter + "=NAME behind *" + parameter + ", found none");
  const std::string instance = keyword.value("INSTANCE");
  InpSets& sets = of_nodes ? parser.part->node_sets : parser.part->element_sets;
  InpSet* set = nullptr;
  if (!instance.empty()) {
    parser.model.assembly_sets.push_back(
        {upper_case(instance), of_nodes, {name, {}, ++parser.sets}});
    set = &parser.model.assembly_sets.back().set;
  } else {
    set = &set_named(parser, sets, name);
  }
  if (of_nodes && keyword.has("ELSET"))
    return parser.fail("expected the ids of nodes in a set, found ELSET: write the nodes out");
  while (parser.input.next_data()) {
    const Status status =
        keyword.has("GENERATE") ? read_range(parser, *set) : read_members(parser, sets, *set);
    if (!status) return status;
  }
  return Success{};
}

// A line of a translation, and one of two points of an axis and an angle in degrees.
Status read_instance(InpParser& parser, const InpKeyword& keyword) {
  InpInstance instance{keyword.value("NAME"), keyword.value("PART")};
  if (keyword.has("LIBRARY") || instance.part.empty())
    return parser.fail("expected *INSTANCE with PART=NAME of this file");
  const auto read = [&](double& value) {
    return parser.input.line().read(value, "a coordinate of an instance");
  };
  if (parser.input.next_data()) {
    Eigen::Vector3d shift;
    for (double& value : shift)
      if (!read(value)) return parser.scan_error();
    if (!shift.allFinite()) return parser.fail("expected a finite translation");
    instance.placed = Eigen::Translation3d(shift);
  }
  if (parser.input.next_data()) {
    Eigen::Vector3d a, b;
    double degrees = 0;
    for (Eigen::Vector3d* point : {&a, &b})
      for (double& value : *point)
        if (!read(value)) return parser.scan_error();
    if (!read(degrees)) return parser.scan_error();
    const Eigen::Vector3d axis = b - a;
    if (!(axis.norm() > 0) || !std::isfinite(axis.norm()) || !std::isfinite(degrees))
      return parser.fail("expected an axis of two different points and an angle");
    const Eigen::AngleAxisd turn(degrees * std::numbers::pi / 180, axis.normalized());
    instance.placed = Eigen::Translation3d(a) * turn * Eigen::Translation3d(-a) * instance.placed;
  }
  parser.model.instances.push_back(std::move(instance));
  return Success{};
}

// The first line of *ELASTIC or *DENSITY of the material above.
Status read_constants(InpParser& parser, const InpKeyword& keyword) {
  const auto found = parser.model.materials.find(parser.material);
  if (found == parser.model.materials.end()) return Success{};
  InpMaterial& material = found->second;
  const std::string type = upper_case(keyword.value("TYPE"));
  if (keyword.name == "ELASTIC" && !type.empty() && type != "ISOTROPIC" && type != "ISO") {
    material.problem = "its *ELASTIC is of type " + type + ", only isotropic ones are read";
    return Success{};
  }
  if (!parser.input.next_data()) return Success{};
  TextScanner& line = parser.input.line();
  if (keyword.name == "DENSITY") {
    material.has_density = true;
    if (!line.read(material.material.density, "a density")) return parser.scan_error();
    return Success{};
  }
  material.has_elastic = true;
  if (!line.read(material.material.young, "Young's modulus") ||
      !line.read(material.material.poisson, "Poisson's ratio"))
    return parser.scan_error();
  return Success{};
}

void begin_part(InpParser& parser, const InpKeyword& keyword) {
  parser.model.parts.push_back({});
  parser.part = &parser.model.parts.back();
  parser.part->name = keyword.value("NAME");
}

Status read_keyword(InpParser& parser, const InpKeyword& keyword) {
  for (const auto& [name, remedy] : kRefused)
    if (keyword.name == name)
      return parser.fail("*" + keyword.name + " is not read: " + std::string(remedy));
  if (keyword.name == "NODE") return read_nodes(parser, keyword);
  if (keyword.name == "ELEMENT") return read_elements(parser, keyword);
  if (keyword.name == "NSET") return read_set(parser, keyword, true);
  if (keyword.name == "ELSET") return read_set(parser, keyword, false);
  if (keyword.name == "INSTANCE") return read_instance(parser, keyword);
  if (keyword.name == "PART") begin_part(parser, keyword);
  if (keyword.name == "END PART") parser.part = &parser.model.flat;
  if (keyword.name == "SOLID SECTION")
    parser.part->sections.push_back(
        {upper_case(keyword.value("ELSET")), upper_case(keyword.value("MATERIAL"))});
  if (keyword.name == "MATERIAL") {
    parser.material = upper_case(keyword.value("NAME"));
    parser.model.materials[parser.material].name = keyword.value("NAME");
  }
  if (keyword.name == "ELASTIC" || keyword.name == "DENSITY")
    return read_constants(parser, keyword);
  return Success{};
}

}  // namespace

Result<InpModel> parse_inp(std::string_view text, const std::string& path) {
  InpParser parser(InpInput(text, path));
  parser.part = &parser.model.flat;
  InpKeyword keyword;
  // The history after *STEP has no mesh.
  while (parser.input.next_keyword(keyword) && keyword.name != "STEP") {
    const Status status = read_keyword(parser, keyword);
    if (!status) return status.error();
  }
  if (parser.input.failed()) return parser.input.error();
  parser.model.bytes = parser.input.bytes();
  return std::move(parser.model);
}

}  // namespace tremolo
