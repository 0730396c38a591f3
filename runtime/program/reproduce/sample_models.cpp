#include "runtime/program/reproduce/sample_models.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/checksum.h"
#include "formats/whole_file.h"
#include "runtime/program/reproduce/thesis.h"

namespace tremolo::reproduce {
namespace {

Status check_names(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (std::ranges::find(thesis::kModels, name) == thesis::kModels.end())
      return Error{ErrorKind::kUsage, fmt::format("unknown model '{}'; there are {}", name,
                                                  fmt::join(thesis::kModels, ", "))};
    if (std::ranges::count(names, name) > 1)
      return Error{ErrorKind::kUsage, fmt::format("model '{}' is named twice", name)};
  }
  return Success{};
}

Result<SampleModel> load_one(const std::string& directory, std::string_view name) {
  const std::string path =
      (std::filesystem::path(directory) / fmt::format("{}.tremolo", name)).string();
  if (!std::filesystem::exists(path))
    return system_error(path +
                        ": there is no such file; ./demo makes the six sample models in "
                        "build/models (--models-dir names another folder)");
  Result<std::string> bytes = read_whole_file(path);
  if (!bytes) return bytes.error();
  Result<Model::Pointer> model = Model::load(path);
  if (!model) return model.error();
  if ((*model)->default_load().vertices.empty())
    return content_error(path + ": the model has no default load");
  return SampleModel{std::string(name), checksum(*bytes), std::move(*model)};
}

}  // namespace

Result<std::vector<SampleModel>> load_sample_models(const std::string& directory,
                                                    const std::vector<std::string>& names) {
  if (Status status = check_names(names); !status) return status.error();
  std::vector<SampleModel> models;
  for (const std::string_view name : thesis::kModels) {
    if (!names.empty() && std::ranges::find(names, name) == names.end()) continue;
    Result<SampleModel> model = load_one(directory, name);
    if (!model) return model.error();
    models.push_back(std::move(*model));
  }
  return models;
}

}  // namespace tremolo::reproduce
