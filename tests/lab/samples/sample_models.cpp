#include "tests/lab/samples/sample_models.h"

#include <algorithm>
#include <array>
#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/basis/basis_reader.h"
#include "formats/file/input_file.h"
#include "formats/file/output_guard.h"
#include "tests/lab/samples/thesis.h"
#include "tests/lab/work/failure.h"

namespace tremolo::reproduce {
namespace {

void check_names(const std::vector<std::string>& names, bool own) {
  for (const std::string& name : names) {
    if (!own && std::ranges::find(thesis::kModels, name) == thesis::kModels.end())
      throw Failure({ErrorKind::kUsage, fmt::format("unknown model '{}'; there are {}", name,
                                                    fmt::join(thesis::kModels, ", "))});
    if (std::ranges::count(names, name) > 1)
      throw Failure({ErrorKind::kUsage, fmt::format("model '{}' is named twice", name)});
  }
}

constexpr std::string_view kBasisEnding = ".tremolo";

// A name, or the path of a basis file.
std::string path_of(const std::string& directory, std::string_view name) {
  if (name.ends_with(kBasisEnding)) return std::string(name);
  return (std::filesystem::path(directory) / fmt::format("{}.tremolo", name)).string();
}

// Names other than the six.
std::vector<std::string> own_ones(const std::vector<std::string>& names) {
  std::vector<std::string> own;
  for (const std::string& name : names)
    if (std::ranges::find(thesis::kModels, name) == thesis::kModels.end()) own.push_back(name);
  return own;
}

bool is_of_a_report(const std::filesystem::path& file) {
  constexpr std::array kEndings = {".html", ".csv", ".svg", ".json"};
  return std::ranges::find(kEndings, file.extension()) != kEndings.end();
}

SampleModel load_one(const std::string& directory, std::string_view name) {
  const std::string path = path_of(directory, name);
  if (!std::filesystem::exists(path))
    throw Failure(system_error(path + ": there is no such file; ./demo makes the six sample models "
                                      "in build/models (--models-dir names another folder)"));
  const std::string bytes = or_fail(read_whole_file(path));
  Model::Pointer model = or_fail(Model::load(path));
  if (model->default_load().vertices.empty())
    throw Failure(content_error(path + ": the model has no default load"));
  BasisReader reader = or_fail(BasisReader::open(path));
  return {std::filesystem::path(path).stem().string(), checksum(bytes), std::move(model),
          or_fail(reader.strain_gram())};
}

}  // namespace

std::vector<SampleModel> load_sample_models(const std::string& directory,
                                            const std::vector<std::string>& names, bool own) {
  check_names(names, own);
  std::vector<SampleModel> models;
  for (const std::string_view name : thesis::kModels)
    if (names.empty() || std::ranges::find(names, name) != names.end())
      models.push_back(load_one(directory, name));
  for (const std::string& name : own_ones(names)) models.push_back(load_one(directory, name));
  return models;
}

void keep_models_apart(const std::string& out, const std::string& directory,
                       const std::vector<std::string>& names, const std::string& published) {
  namespace fs = std::filesystem;
  std::vector<NamedFile> inputs;
  if (!published.empty())
    for (const std::string& file : files_like(published, [](std::string_view) { return true; }))
      inputs.push_back({file, "--published"});
  for (const std::string_view name : thesis::kModels)
    if (names.empty() || std::ranges::find(names, name) != names.end())
      inputs.push_back({path_of(directory, name), "a model"});
  for (const std::string& name : own_ones(names))
    inputs.push_back({path_of(directory, name), "a model"});
  std::vector<std::string> outputs;
  std::error_code error;
  for (fs::recursive_directory_iterator at(out, error), end; !error && at != end;
       at.increment(error))
    if (is_of_a_report(at->path())) outputs.push_back(at->path().string());
  or_fail(keep_apart(outputs, inputs));
}

}  // namespace tremolo::reproduce
