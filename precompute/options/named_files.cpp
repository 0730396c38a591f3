#include "precompute/options/named_files.h"

#include "common/mesh/selector.h"

namespace tremolo {
namespace {

void add_files(const std::vector<std::string>& paths, const std::string& option,
               std::vector<NamedFile>& files) {
  for (const std::string& path : paths) files.push_back({path, "the ids of " + option});
}

}  // namespace

void add_files_of_selector(const std::string& text, const std::string& option,
                           std::vector<NamedFile>& files) {
  add_files(files_of_selector(text), option, files);
}

std::vector<NamedFile> input_files(const ProblemRequest& request, const std::string& config_path) {
  std::vector<NamedFile> files{{request.files.mesh, "the mesh", true},
                               {config_path, "--config"},
                               {request.files.render, "--render", true}};
  const auto add = [&files](const Selector& selector, const char* option) {
    add_files(files_of_selector(selector), option, files);
  };
  for (const Selector& selector : request.support.fixed) add(selector, "--fix");
  for (const auto& selectors : request.support.along)
    for (const Selector& selector : selectors) add(selector, "--fix-x, --fix-y or --fix-z");
  if (request.load) add(request.load->at, "--load-at");
  for (const PointMassRequest& mass : request.point_masses) add(mass.at, "--point-mass");
  for (const MaterialRule& rule : request.materials.rules)
    if (rule.selector) add(*rule.selector, "--material");
  return files;
}

}  // namespace tremolo
