#include "precompute/options/named_files.h"

#include "common/mesh/selector.h"
#include "precompute/problem/material_rules.h"

namespace tremolo {

void add_files_of_selector(const std::string& text, const std::string& option,
                           std::vector<NamedFile>& files) {
  for (const std::string& file : files_of_selector(text))
    files.push_back({file, "the ids of " + option});
}

std::vector<NamedFile> input_files(const ProblemRequest& request, const std::string& config_path) {
  std::vector<NamedFile> files{{request.mesh_path, "the mesh", true},
                               {config_path, "--config"},
                               {request.render_path, "--render", true}};
  for (const std::string& selector : request.fix) add_files_of_selector(selector, "--fix", files);
  for (const auto& selectors : request.fix_axis)
    for (const std::string& selector : selectors)
      add_files_of_selector(selector, "--fix-x, --fix-y or --fix-z", files);
  add_files_of_selector(request.load_at, "--load-at", files);
  add_files_of_selector(request.select, "--select", files);
  for (const std::string& mass : request.point_masses)
    add_files_of_selector(mass.substr(0, mass.rfind('=')), "--point-mass", files);
  for (const std::string& text : request.materials)
    if (const Result<MaterialRule> rule = parse_material_rule(text, request.material); rule)
      add_files_of_selector(rule->where, "--material", files);
  return files;
}

}  // namespace tremolo
