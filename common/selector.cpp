#include "common/selector.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>
#include <sstream>
#include <string_view>
#include <type_traits>
#include <utility>

namespace tremolo {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

template <class T>
std::optional<T> number(std::string_view text) {
  text = trimmed(text);
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  T value{};
  const char* end = text.data() + text.size();
  const auto [stop, code] = std::from_chars(text.data(), end, value);
  if (code != std::errc{} || stop != end) return std::nullopt;
  if constexpr (std::is_floating_point_v<T>)
    if (!std::isfinite(value)) return std::nullopt;
  return value;
}

template <class T>
std::optional<std::vector<T>> number_list(std::string_view text) {
  std::vector<T> values;
  for (;;) {
    const std::size_t comma = text.find(',');
    const std::optional<T> value = number<T>(text.substr(0, comma));
    if (!value) return std::nullopt;
    values.push_back(*value);
    if (comma == std::string_view::npos) return values;
    text.remove_prefix(comma + 1);
  }
}

Error malformed(const std::string& text, const std::string& what) {
  return {ErrorKind::kUsage,
          "selector `" + text + "`: expected " + what + "; a selector is " + kSelectorGrammar};
}

// An axis and a comparison sign make a half space; nullopt: the text is something else.
std::optional<Result<Selector>> parse_half_space(const std::string& text, std::string_view body) {
  if (body.empty() || body[0] < 'x' || body[0] > 'z') return std::nullopt;
  const std::string_view rest = trimmed(body.substr(1));
  if (rest.empty() || (rest[0] != '<' && rest[0] != '>' && rest[0] != '=')) return std::nullopt;
  using Comparison = SelectHalfSpace::Comparison;
  const bool or_equal = rest.size() > 1 && rest[1] == '=';
  const std::optional<double> bound = number<double>(rest.substr(or_equal ? 2 : 1));
  if (rest[0] == '=' || !bound) return malformed(text, "<, <=, > or >= and a finite number");
  SelectHalfSpace half{body[0] - 'x', Comparison::kLess, *bound};
  if (rest[0] == '<')
    half.comparison = or_equal ? Comparison::kLessEqual : Comparison::kLess;
  else
    half.comparison = or_equal ? Comparison::kGreaterEqual : Comparison::kGreater;
  return Selector{text, half};
}

Result<Selector> parse_box(const std::string& text, std::string_view body) {
  const auto values = number_list<double>(body);
  if (!values || values->size() != 6) return malformed(text, "six finite numbers behind `box:`");
  const std::vector<double>& v = *values;
  const BoundingBox box{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}};
  if ((box.low.array() > box.high.array()).any())
    return malformed(text, "a box whose first corner is not above its second");
  return Selector{text, SelectBox{box}};
}

bool is_inside(const SelectHalfSpace& half, const Eigen::Vector3d& x) {
  switch (half.comparison) {
    case SelectHalfSpace::Comparison::kLess:
      return x[half.axis] < half.bound;
    case SelectHalfSpace::Comparison::kLessEqual:
      return x[half.axis] <= half.bound;
    case SelectHalfSpace::Comparison::kGreater:
      return x[half.axis] > half.bound;
    case SelectHalfSpace::Comparison::kGreaterEqual:
      return x[half.axis] >= half.bound;
  }
  return false;
}

bool is_inside(const SelectBox& select, const Eigen::Vector3d& x) {
  return (x.array() >= select.box.low.array()).all() &&
         (x.array() <= select.box.high.array()).all();
}

std::string describe_sets(const TetMesh& mesh) {
  if (mesh.node_sets.empty()) return "it has no named sets";
  std::string text = "its sets are";
  const char* separator = " ";
  for (const auto& [name, ids] : mesh.node_sets) {
    text += separator + ("`" + name + "`");
    separator = ", ";
  }
  return text;
}

Error nothing_found(const Selector& selector, const TetMesh& mesh) {
  const BoundingBox box = bounding_box(mesh.vertices);
  std::ostringstream text;
  text << "selector `" << selector.text << "` selects no vertex: the mesh extends from ("
       << box.low.x() << ", " << box.low.y() << ", " << box.low.z() << ") to (" << box.high.x()
       << ", " << box.high.y() << ", " << box.high.z() << ") m and " << describe_sets(mesh);
  return content_error(text.str());
}

// One flag a vertex.
std::vector<bool> referenced_vertices(const TetMesh& mesh) {
  std::vector<bool> referenced(mesh.vertices.size(), false);
  for (const Tetrahedron& tet : mesh.tetrahedra)
    for (VertexId v : tet) referenced[v] = true;
  return referenced;
}

Status check_explicit(const Selector& selector, const std::vector<VertexId>& ids,
                      const std::vector<bool>& referenced) {
  for (VertexId id : ids) {
    if (id < 0 || static_cast<std::size_t>(id) >= referenced.size())
      return content_error("selector `" + selector.text + "`: vertex " + std::to_string(id) +
                           " is not in the mesh, whose vertices are 0 to " +
                           std::to_string(referenced.size() - 1));
    if (!referenced[id])
      return content_error("selector `" + selector.text + "`: vertex " + std::to_string(id) +
                           " belongs to no tetrahedron");
  }
  return Success{};
}

template <class Region>
std::vector<VertexId> vertices_inside(const Region& region, const TetMesh& mesh) {
  std::vector<VertexId> ids;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (is_inside(region, mesh.vertices[v])) ids.push_back(static_cast<VertexId>(v));
  return ids;
}

Result<std::vector<VertexId>> find_candidates(const Selector& selector, const TetMesh& mesh,
                                              const std::vector<bool>& referenced) {
  if (const auto* half = std::get_if<SelectHalfSpace>(&selector.choice))
    return vertices_inside(*half, mesh);
  if (const auto* box = std::get_if<SelectBox>(&selector.choice))
    return vertices_inside(*box, mesh);
  if (const auto* file = std::get_if<SelectFile>(&selector.choice)) return file->ids;
  if (const auto* list = std::get_if<SelectVertices>(&selector.choice)) {
    const Status status = check_explicit(selector, list->ids, referenced);
    if (!status) return status.error();
    return list->ids;
  }
  const std::string& name = std::get<SelectSet>(selector.choice).name;
  const auto found = mesh.node_sets.find(name);
  if (found != mesh.node_sets.end()) return found->second;
  return Error{ErrorKind::kUsage, "selector `" + selector.text +
                                      "`: the mesh has no set of this name; " +
                                      describe_sets(mesh) + "; a selector is " + kSelectorGrammar};
}

}  // namespace

Result<Selector> parse_selector(const std::string& text) {
  const std::string_view body = trimmed(text);
  if (body.empty()) return malformed(text, "a text that is not empty");
  if (body == "none") return Selector{text, SelectNone{}};
  if (body.starts_with("box:")) return parse_box(text, body.substr(4));
  if (body.starts_with("vertex:")) {
    auto ids = number_list<VertexId>(body.substr(7));
    if (!ids || *std::min_element(ids->begin(), ids->end()) < 0)
      return malformed(text, "vertex ids from 0, separated by commas, behind `vertex:`");
    return Selector{text, SelectVertices{std::move(*ids)}};
  }
  if (body.starts_with("file:")) {
    const std::string_view path = trimmed(body.substr(5));
    if (path.empty()) return malformed(text, "a path behind `file:`");
    return Selector{text, SelectFile{std::string(path), {}}};
  }
  if (auto half_space = parse_half_space(text, body)) return *half_space;
  return Selector{text, SelectSet{std::string(body)}};
}

Result<std::vector<VertexId>> select_vertices(const Selector& selector, const TetMesh& mesh) {
  if (std::holds_alternative<SelectNone>(selector.choice)) return std::vector<VertexId>{};
  const std::vector<bool> referenced = referenced_vertices(mesh);
  Result<std::vector<VertexId>> found = find_candidates(selector, mesh, referenced);
  if (!found) return found;
  std::vector<VertexId>& ids = *found;
  std::erase_if(ids, [&](VertexId id) {
    return id < 0 || static_cast<std::size_t>(id) >= referenced.size() || !referenced[id];
  });
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  if (ids.empty()) return nothing_found(selector, mesh);
  return found;
}

}  // namespace tremolo
