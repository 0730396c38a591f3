#include <algorithm>
#include <cmath>
#include <map>
#include <variant>

#include "common/text.h"
#include "formats/basis/selector_reader.h"
#include "precompute/problem/material_rules.h"

namespace tremolo {
namespace {

// Returns the tetrahedra inside the object of that name, or those all of whose vertices the
// selector selects; an error if there are none.
Result<std::vector<std::size_t>> covered(const MaterialRule& rule, const TetMesh& mesh) {
  const auto* set = rule.selector ? std::get_if<SelectSet>(&rule.selector->choice) : nullptr;
  const auto solid = mesh.solids.find(set != nullptr ? set->name : rule.where);
  if (solid != mesh.solids.end() && (set == nullptr || rule.selector->further.empty()))
    return std::vector<std::size_t>(solid->second.begin(), solid->second.end());
  const Result<std::vector<VertexId>> vertices =
      rule.selector ? resolve_selector(*rule.selector, mesh) : rule.selector.error();
  if (!vertices) {
    Error error = vertices.error();
    error.message = "--material `" + rule.where + "` is no region: " + list_regions(mesh) + "; " +
                    error.message;
    return error;
  }
  std::vector<bool> selected(mesh.vertices.size(), false);
  for (VertexId v : *vertices) selected[v] = true;
  std::vector<std::size_t> chosen;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    const Tetrahedron& tet = mesh.tetrahedra[t];
    if (std::all_of(tet.begin(), tet.end(), [&](VertexId v) { return selected[v]; }))
      chosen.push_back(t);
  }
  if (chosen.empty())
    return content_error("--material `" + rule.where +
                         "` covers no tetrahedron: a selector takes those all of whose vertices it "
                         "selects");
  return chosen;
}

using RegionIndex = std::map<std::string, std::size_t>;

// Returns the rules that the option value `file` stands for.
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
  std::vector<std::int32_t> new_index(table.materials.size(), -1);
  std::vector<bool> used(table.materials.size(), false);
  for (std::int32_t of : table.of_tet) used[of] = true;
  MaterialTable result;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    new_index[i] = static_cast<std::int32_t>(result.materials.size());
    result.materials.push_back(std::move(table.materials[i]));
  }
  if (result.materials.size() == 1) return result;
  for (std::int32_t of : table.of_tet) result.of_tet.push_back(new_index[of]);
  return result;
}

}  // namespace

std::string list_regions(const TetMesh& mesh) {
  constexpr std::size_t kNamed = 20;
  if (mesh.region_names.empty()) return "the mesh has no regions";
  std::string text = "the regions of the mesh are";
  const char* separator = " ";
  for (std::size_t i = 0; i < std::min(kNamed, mesh.region_names.size()); ++i) {
    text += separator + ("`" + mesh.region_names[i] + "`");
    separator = ", ";
  }
  if (mesh.region_names.size() > kNamed)
    text += " and " + std::to_string(mesh.region_names.size() - kNamed) + " more";
  return text;
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
  // Consecutive rules for regions are collected, so that one pass over the mesh applies them all.
  std::vector<std::int32_t> of_region(regions.size(), -1);
  const auto flush = [&] {
    for (std::size_t t = 0; t < mesh.region_of.size(); ++t) {
      const std::int32_t region = mesh.region_of[t];
      const std::int32_t of = region < 0 ? -1 : of_region[region];
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
    const Result<std::vector<std::size_t>> chosen = covered(rule, mesh);
    if (!chosen) return chosen.error();
    for (std::size_t t : *chosen) table.of_tet[t] = material;
  }
  flush();
  return compacted(std::move(table));
}

std::vector<MaterialShare> material_shares(const MaterialTable& table, const TetMesh& mesh) {
  std::vector<MaterialShare> shares(table.materials.size());
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    MaterialShare& share = shares[table.of_tet.empty() ? 0 : table.of_tet[t]];
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
