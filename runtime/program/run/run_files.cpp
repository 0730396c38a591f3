#include "runtime/program/run/run_files.h"

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/mesh/selector.h"
#include "runtime/program/output/plot.h"
#include "runtime/program/start/start_state.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

// As frame_name() makes it, now and without the time in earlier versions.
bool is_frame_name(std::string_view name) {
  constexpr std::string_view kStart = "surface-";
  const auto skip_digits = [&name] {
    const std::size_t count = std::min(name.find_first_not_of("0123456789"), name.size());
    name.remove_prefix(count);
    return count;
  };
  if (!name.starts_with(kStart)) return false;
  name.remove_prefix(kStart.size());
  if (skip_digits() < 4) return false;
  if (name.starts_with("-t")) {
    name.remove_prefix(2);
    if (skip_digits() == 0 || !name.starts_with('.')) return false;
    name.remove_prefix(1);
    if (skip_digits() == 0 || !name.starts_with('s')) return false;
    name.remove_prefix(1);
  }
  return name == ".ply" || name == ".obj" || name == ".inc";
}

bool is_of_a_run(const std::string& name) {
  return is_frame_name(name) || name == kPictureName || name == kEnergyPageName ||
         name == kFramesName || name == kMaterialsName;
}

}  // namespace

std::vector<NamedFile> inputs_of(const RunOptions& options) {
  std::vector<NamedFile> inputs{{options.model, "the basis file"},
                                {options.scene, "the scene"},
                                {options.signal, "--signal"},
                                {file_of_start(options.start), "--start"}};
  const auto add = [&inputs](const std::string& text, const char* option) {
    for (const std::string& file : files_of_selector(text))
      inputs.push_back({file, std::string("the ids of ") + option});
  };
  add(options.at, "--at");
  add(selector_of_start(options.start), "--start");
  for (const std::string& probe : options.probes) add(probe, "--probe");
  return inputs;
}

std::string frame_name(int frame, double time, const std::string& format) {
  return fmt::format("surface-{:04}-t{:.6f}s.{}", frame, time, format);
}

Status keep_run_apart(const RunOptions& options) {
  const std::vector<NamedFile> inputs = inputs_of(options);
  std::vector<std::string> outputs;
  if (!options.wav.empty()) outputs.push_back(options.wav);
  if (options.out.empty()) return outputs.empty() ? Status(Success{}) : keep_apart(outputs, inputs);
  for (const char* name :
       {kTableName, kReportName, kEnergyPageName, kPictureName, kFramesName, kMaterialsName})
    outputs.push_back((fs::path(options.out) / name).string());
  // Surfaces that are there will be written anew or removed.
  std::error_code error;
  for (fs::directory_iterator at(options.out, error), end; !error && at != end; at.increment(error))
    if (is_frame_name(at->path().filename().string())) outputs.push_back(at->path().string());
  return keep_apart(outputs, inputs);
}

Status remove_leftovers(const std::string& folder, const std::vector<std::string>& written) {
  std::error_code error, ignored;
  std::vector<fs::path> old;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    if (is_of_a_run(name) && at->is_regular_file(ignored) &&
        std::find(written.begin(), written.end(), (fs::path(folder) / name).string()) ==
            written.end())
      old.push_back(at->path());
  }
  for (const fs::path& path : old)
    if (!error) fs::remove(path, error);
  if (error) return system_error(folder + ": cannot remove old surfaces: " + error.message());
  return Success{};
}

std::string list_files(const std::vector<std::string>& files) {
  std::vector<std::string> names;
  std::size_t surfaces = 0;
  for (const std::string& file : files) {
    const std::string name = fs::path(file).filename().string();
    if (is_frame_name(name))
      ++surfaces;
    else
      names.push_back(name);
  }
  if (surfaces > 0) names.push_back(fmt::format("{} surface{}", surfaces, surfaces > 1 ? "s" : ""));
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace tremolo
