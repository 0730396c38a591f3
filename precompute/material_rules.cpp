#include "precompute/material_rules.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <string_view>

#include "common/number_text.h"
#include "formats/selector_reader.h"

namespace tremolo {
namespace {

constexpr const char* kFile = "file";

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

Error malformed(const std::string& text, const std::string& what) {
  return {ErrorKind::kUsage,
          "--material `" + text + "`: expected " + what + "; a material is " + kMaterialGrammar};
}

// Numbers separated by blanks, all of the text.
bool read_numbers(std::string_view text, std::vector<double>& numbers) {
  for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
    double value = 0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{}) return false;
    text.remove_prefix(static_cast<std::size_t>(stop - text.data()));
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

std::string list_regions(const TetMesh& mesh) {
  if (mesh.region_names.empty()) return "the mesh has no regions";
  std::string text = "the regions of the mesh are";
  const char* separator = " ";
  for (const std::string& name : mesh.region_names) {
    text += separator + ("`" + name + "`");
    separator = ", ";
  }
  return text;
}

// The tetrahedra all of whose vertices a selector selects.
Result<std::vector<std::size_t>> covered(const std::string& where, const TetMesh& mesh) {
  const Result<std::vector<VertexId>> vertices = resolve_selector(where, mesh);
  if (!vertices) {
    Error error = vertices.error();
    error.message =
        "--material `" + where + "` is no region: " + list_regions(mesh) + "; " + error.message;
    return error;
  }
  std::vector<bool> selected(mesh.vertices.size(), false);
  for (VertexId v : *vertices) selected[static_cast<std::size_t>(v)] = true;
  std::vector<std::size_t> chosen;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    const Tetrahedron& tet = mesh.tetrahedra[t];
    if (std::all_of(tet.begin(), tet.end(),
                    [&](VertexId v) { return selected[static_cast<std::size_t>(v)]; }))
      chosen.push_back(t);
  }
  if (chosen.empty())
    return content_error("--material `" + where +
                         "` is of no tetrahedron: a selector takes those all of whose vertices it "
                         "selects");
  return chosen;
}

using RegionIndex = std::map<std::string, std::size_t>;

// The rules that `file` stands for.
Result<std::vector<MaterialRule>> rules_of_file(const RegionIndex& regions,
                                                const std::vector<FileMaterial>& of_file) {
  std::vector<MaterialRule> rules;
  for (const FileMaterial& found : of_file) {
    if (!regions.contains(found.region)) continue;
    if (!found.problem.empty())
      return content_error("the material of region `" + found.region + "` cannot be used: " +
                           found.problem + "; give one with --material, without `file`");
    rules.push_back({found.region, found.material});
  }
  if (rules.empty())
    return content_error("--material file: the mesh's file gives no region a material");
  return rules;
}

// Drops the materials that have no tetrahedron left.
MaterialTable compacted(MaterialTable table) {
  std::vector<std::int32_t> place(table.materials.size(), -1);
  std::vector<bool> used(table.materials.size(), false);
  for (std::int32_t of : table.of_tet) used[static_cast<std::size_t>(of)] = true;
  MaterialTable result;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    place[i] = static_cast<std::int32_t>(result.materials.size());
    result.materials.push_back(std::move(table.materials[i]));
  }
  if (result.materials.size() == 1) return result;
  for (std::int32_t of : table.of_tet) result.of_tet.push_back(place[static_cast<std::size_t>(of)]);
  return result;
}

}  // namespace

Result<MaterialRule> parse_material_rule(const std::string& text, const Material& usual) {
  if (trimmed(text) == kFile) return MaterialRule{};
  // No constant holds a colon, but selectors do.
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return malformed(text, "a colon behind the region");
  MaterialRule rule{std::string(trimmed(std::string_view(text).substr(0, colon))), usual};
  if (rule.where.empty()) return malformed(text, "a region before the colon");
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

Result<MaterialTable> assign_materials(const std::vector<MaterialRule>& rules,
                                       const Material& usual, const TetMesh& mesh,
                                       const std::vector<FileMaterial>& of_file) {
  MaterialTable table;
  table.materials.push_back({"default", usual});
  if (rules.empty()) return table;
  table.of_tet.assign(mesh.tetrahedra.size(), 0);
  RegionIndex regions;
  for (std::size_t i = 0; i < mesh.region_names.size(); ++i) regions[mesh.region_names[i]] = i;
  std::vector<MaterialRule> all;
  for (const MaterialRule& rule : rules) {
    if (!rule.where.empty()) {
      all.push_back(rule);
      continue;
    }
    const Result<std::vector<MaterialRule>> found = rules_of_file(regions, of_file);
    if (!found) return found.error();
    all.insert(all.end(), found->begin(), found->end());
  }
  // Rules of regions wait for each other: one pass over the mesh for all that stand together.
  std::vector<std::int32_t> of_region(regions.size(), -1);
  const auto flush = [&] {
    for (std::size_t t = 0; t < mesh.region_of.size(); ++t) {
      const std::int32_t region = mesh.region_of[t];
      const std::int32_t of = region < 0 ? -1 : of_region[static_cast<std::size_t>(region)];
      if (of >= 0) table.of_tet[t] = of;
    }
    of_region.assign(regions.size(), -1);
  };
  for (const MaterialRule& rule : all) {
    const auto material = static_cast<std::int32_t>(table.materials.size());
    table.materials.push_back({rule.where, rule.material});
    if (const auto region = regions.find(rule.where); region != regions.end()) {
      of_region[region->second] = material;
      continue;
    }
    flush();
    const Result<std::vector<std::size_t>> chosen = covered(rule.where, mesh);
    if (!chosen) return chosen.error();
    for (std::size_t t : *chosen) table.of_tet[t] = material;
  }
  flush();
  return compacted(std::move(table));
}

std::vector<MaterialShare> material_shares(const MaterialTable& table, const TetMesh& mesh) {
  std::vector<MaterialShare> shares(table.materials.size());
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    MaterialShare& share =
        shares[table.of_tet.empty() ? 0 : static_cast<std::size_t>(table.of_tet[t])];
    ++share.tetrahedra;
    share.volume += std::abs(signed_volume(mesh, mesh.tetrahedra[t]));
  }
  return shares;
}

std::string describe(const Material& material) {
  const auto three = [](const Eigen::Vector3d& v) {
    return number_text(v[0]) + ", " + number_text(v[1]) + ", " + number_text(v[2]);
  };
  const std::string density = number_text(material.density) + " kg/m^3";
  if (!material.orthotropic)
    return "E " + number_text(material.young) + " Pa, nu " + number_text(material.poisson) + ", " +
           density;
  const OrthotropicElasticity& o = *material.orthotropic;
  return "orthotropic, E " + three(o.young) + " Pa, nu " + three(o.poisson) + ", G " +
         three(o.shear) + " Pa, axes (" + three(o.axes.col(0)) + "), (" + three(o.axes.col(1)) +
         "), " + density;
}

}  // namespace tremolo
