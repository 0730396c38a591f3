#include "precompute/problem/problem_request.h"

#include <algorithm>
#include <charconv>

#include "precompute/system/failure.h"

namespace tremolo {
namespace {

std::vector<Selector> parse_selectors(const std::vector<std::string>& texts) {
  std::vector<Selector> selectors;
  for (const std::string& text : texts) selectors.push_back(unwrap(parse_selector(text)));
  return selectors;
}

std::optional<LengthUnit> parse_unit(const std::string& text) {
  if (text.empty()) return std::nullopt;
  return unwrap(parse_length_unit(text));
}

MaterialRequest parse_materials(const SolidTexts& texts) {
  unwrap(check_material(texts.material));
  MaterialRequest request{texts.material, {}};
  for (const std::string& text : texts.materials)
    request.rules.push_back(unwrap(parse_material_rule(text, texts.material)));
  return request;
}

SupportRequest parse_support(const SolidTexts& texts) {
  const auto refuse = [](const std::string& text) { throw Failure({ErrorKind::kUsage, text}); };
  const bool none = std::find(texts.fix.begin(), texts.fix.end(), "none") != texts.fix.end();
  if (none && texts.fix.size() > 1) refuse("--fix none and another --fix contradict each other");
  SupportRequest request;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (none && !texts.fix_axis[axis].empty())
      refuse("--fix none and --fix-x, --fix-y or --fix-z contradict each other");
  request.fixed = parse_selectors(texts.fix);
  for (std::size_t axis = 0; axis < 3; ++axis)
    request.along[axis] = parse_selectors(texts.fix_axis[axis]);
  return request;
}

std::optional<LoadRequest> parse_load(const SolidTexts& texts, bool loaded) {
  LoadRequest request;
  if (!texts.load_force.empty() && !parse_vector(texts.load_force, request.force))
    throw Failure({ErrorKind::kUsage,
                   "--load-force " + texts.load_force + ": expected three numbers, X,Y,Z in N"});
  if (texts.load_at.empty()) return std::nullopt;
  request.at = unwrap(parse_selector(texts.load_at));
  if (loaded && (!request.force.allFinite() || request.force.norm() == 0.0))
    throw Failure(
        content_error("--load-at needs --load-force with a finite force other than zero"));
  return request;
}

ElementRequest parse_elements(const SolidTexts& texts) {
  ElementRequest request;
  request.mass = texts.mass == "lumped" ? MassKind::kLumped : MassKind::kConsistent;
  request.refine = texts.refine;
  request.order.reset();
  if (texts.order != "auto") request.order = texts.order == "1" ? 1 : 2;
  if (texts.subdivide != "auto") request.subdivide = texts.subdivide == "on";
  return request;
}

}  // namespace

std::vector<std::string> texts_of(const std::vector<Selector>& selectors) {
  std::vector<std::string> texts;
  for (const Selector& selector : selectors) texts.push_back(selector.text);
  return texts;
}

bool parse_vector(const std::string& text, Eigen::Vector3d& vector) {
  const char* at = text.data();
  const char* end = at + text.size();
  for (int axis = 0; axis < 3; ++axis) {
    const auto [next, error] = std::from_chars(at, end, vector[axis]);
    if (error != std::errc{}) return false;
    at = next;
    if (axis < 2) {
      if (at == end || *at != ',') return false;
      ++at;
    }
  }
  return at == end;
}

ProblemRequest read_problem_request(const SolidTexts& texts, bool loaded) {
  ProblemRequest request;
  request.materials = parse_materials(texts);
  request.support = parse_support(texts);
  request.load = parse_load(texts, loaded);
  for (const std::string& text : texts.point_masses)
    request.point_masses.push_back(unwrap(parse_point_mass(text)));
  request.files = {
      texts.mesh,  texts.render,    parse_unit(texts.unit), parse_unit(texts.mesh_unit),
      texts.merge, texts.up == "y", texts.meshing};
  request.elements = parse_elements(texts);
  request.threads = texts.threads;
  return request;
}

}  // namespace tremolo
