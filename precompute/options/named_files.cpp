#include "precompute/options/named_files.h"

#include "common/mesh/selector.h"
#include "precompute/problem/material_rules.h"

namespace tremolo {

void add_files_of_selector(const std::string& text, const std::string& option,
                           std::vector<NamedFile>& files) {
  for (const std::string& file : files_of_selector(text))
    files.push_back({file, "the ids of " + option});
}

std::vector<NamedFile> input_files(const PrecomputeOptions& options) {
  std::vector<NamedFile> files{{options.mesh_path, "the mesh", true},
                               {options.config_path, "--config"},
                               {options.render_path, "--render", true},
                               {options.import_basis, "--import-basis"},
                               {options.import_cubic, "--import-cubic"}};
  for (const std::string& selector : options.fix) add_files_of_selector(selector, "--fix", files);
  for (const auto& selectors : options.fix_axis)
    for (const std::string& selector : selectors)
      add_files_of_selector(selector, "--fix-x, --fix-y or --fix-z", files);
  add_files_of_selector(options.load_at, "--load-at", files);
  add_files_of_selector(options.select, "--select", files);
  for (const std::string& mass : options.point_masses)
    add_files_of_selector(mass.substr(0, mass.rfind('=')), "--point-mass", files);
  for (const std::string& text : options.materials)
    if (const Result<MaterialRule> rule = parse_material_rule(text, options.material); rule)
      add_files_of_selector(rule->where, "--material", files);
  return files;
}

}  // namespace tremolo
