#include "precompute/problem/material_rules.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <string_view>

#include "common/text.h"

namespace tremolo {
namespace {

constexpr const char* kFile = "file";

Error malformed(const std::string& text, const std::string& what) {
  return {ErrorKind::kUsage,
          "--material `" + text + "`: expected " + what + "; a material is " + kMaterialGrammar};
}

// Reads the whole text as numbers separated by blanks; returns false if anything else stands in it.
bool read_numbers(std::string_view text, std::vector<double>& numbers) {
  for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
    double value = 0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{}) return false;
    text.remove_prefix(stop - text.data());
    if (!text.empty() && text.front() != ' ' && text.front() != '\t') return false;
    numbers.push_back(value);
  }
  return true;
}

using Constants = std::map<std::string, std::vector<double>>;

constexpr const char* kIsotropic[] = {"young", "poisson"};
constexpr const char* kNine[] = {"e1", "e2", "e3", "nu12", "nu23", "nu31", "g12", "g23", "g31"};
constexpr const char* kAxes[] = {"axis1", "axis2"};

template <class Names>
bool is_one_of(const Names& names, const std::string& key) {
  return std::find(std::begin(names), std::end(names), key) != std::end(names);
}

Result<Constants> read_constants(const std::string& text, std::string_view list) {
  Constants constants;
  while (true) {
    const std::size_t comma = list.find(',');
    const std::string_view item = trimmed(list.substr(0, comma));
    const std::size_t equals = item.find('=');
    std::string key(trimmed(item.substr(0, equals)));
    for (char& c : key)
      if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    const bool axis = is_one_of(kAxes, key);
    if (equals == std::string_view::npos ||
        !(axis || key == "density" || is_one_of(kIsotropic, key) || is_one_of(kNine, key)))
      return malformed(text,
                       "KEY=VALUE with a key of a material, found `" + std::string(item) + "`");
    std::vector<double> numbers;
    if (!read_numbers(item.substr(equals + 1), numbers) || numbers.size() != (axis ? 3u : 1u))
      return malformed(text,
                       (axis ? "three numbers" : "a number") + std::string(" behind ") + key + "=");
    if (!constants.try_emplace(key, numbers).second)
      return malformed(text, key + " once, found it twice");
    if (comma == std::string_view::npos) return constants;
    list.remove_prefix(comma + 1);
  }
}

Result<OrthotropicElasticity> orthotropic_of(const std::string& text, const Constants& constants) {
  double nine[9];
  for (std::size_t i = 0; i < 9; ++i) {
    const auto found = constants.find(kNine[i]);
    if (found == constants.end())
      return malformed(text, std::string(kNine[i]) + "=, one of an orthotropic material's nine");
    nine[i] = found->second.front();
  }
  OrthotropicElasticity elasticity;
  elasticity.young << nine[0], nine[1], nine[2];
  elasticity.poisson << nine[3], nine[4], nine[5];
  elasticity.shear << nine[6], nine[7], nine[8];
  Eigen::Vector3d directions[2];
  for (int i = 0; i < 2; ++i) {
    const auto found = constants.find(kAxes[i]);
    directions[i] = found == constants.end() ? Eigen::Vector3d(Eigen::Vector3d::Unit(i))
                                             : Eigen::Vector3d(found->second.data());
  }
  const Result<Eigen::Matrix3d> axes = material_axes(directions[0], directions[1]);
  if (!axes) return content_error("--material `" + text + "`: " + axes.error().message);
  elasticity.axes = *axes;
  return elasticity;
}

}  // namespace

Result<MaterialRule> parse_material_rule(const std::string& text, const Material& usual) {
  if (trimmed(text) == kFile) return MaterialRule{};
  // Selectors may contain colons, constants never do: the last colon separates them.
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return malformed(text, "a colon behind the region");
  const std::string where(trimmed(std::string_view(text).substr(0, colon)));
  if (where.empty()) return malformed(text, "a region before the colon");
  MaterialRule rule{where, usual, parse_selector(where)};
  const Result<Constants> constants =
      read_constants(text, std::string_view(text).substr(colon + 1));
  if (!constants) return constants.error();
  const auto has = [&](const char* key) { return constants->contains(key); };
  const auto take = [&](const char* key, double& value) {
    if (has(key)) value = constants->at(key).front();
  };
  const bool orthotropic = std::any_of(std::begin(kNine), std::end(kNine), has) ||
                           std::any_of(std::begin(kAxes), std::end(kAxes), has);
  if (orthotropic && (has("young") || has("poisson")))
    return malformed(text, "either young and poisson or an orthotropic material");
  take("density", rule.material.density);
  take("young", rule.material.young);
  take("poisson", rule.material.poisson);
  if (orthotropic) {
    Result<OrthotropicElasticity> elasticity = orthotropic_of(text, *constants);
    if (!elasticity) return elasticity.error();
    rule.material.orthotropic = *elasticity;
  }
  const Status status = check_material(rule.material);
  if (!status) return content_error("--material `" + text + "`: " + status.error().message);
  return rule;
}

}  // namespace tremolo
