#include "runtime/apps/tremolo/run/run_files.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <string_view>
#include <unordered_set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/mesh/selector.h"
#include "runtime/apps/tremolo/output/plot.h"
#include "runtime/apps/tremolo/start/start_state.h"

namespace tremolo {

namespace fs = std::filesystem;

void add_ids_of(const std::string& selector, const std::string& whose,
                std::vector<NamedFile>& inputs) {
  for (const std::string& file : files_of_selector(selector))
    inputs.push_back({file, "the ids of " + whose});
}

std::vector<NamedFile> inputs_of(const BodyScene& scene) {
  std::vector<NamedFile> inputs{{scene.body().model, "the basis file"},
                                {scene.file.path, "the scene"},
                                {file_of_start(scene.start), "--start"},
                                {scene.file.outputs.restore, "--restore"}};
  for (const std::string& csv : scene.file.files) inputs.push_back({csv, "--signal"});
  add_ids_of(scene.load().at, "--at", inputs);
  add_ids_of(scene.file.outputs.listen, "--listen", inputs);
  add_ids_of(selector_of_start(scene.start), "--start", inputs);
  for (const std::string& probe : scene.body().columns.probes) add_ids_of(probe, "--probe", inputs);
  return inputs;
}

std::string frame_name(int frame, double time, const std::string& format) {
  return fmt::format("surface-{:04}-t{:.6f}s.{}", frame, time, format);
}

void RunOutputs::add(const std::string& path) {
  if (!path.empty()) named_.push_back(path);
}

void RunOutputs::add_folder(const std::string& folder, const std::vector<std::string>& bodies) {
  if (folder.empty()) return;
  folders_.push_back(folder);
  for (const std::string& body : bodies) folders_.push_back((fs::path(folder) / body).string());
  earlier_.push_back(EarlierRun::in(folder, bodies));
}

void RunOutputs::add_files(const std::string& folder, const std::vector<const char*>& names) {
  if (folder.empty()) return;
  for (const char* name : names) in_folders_.push_back((fs::path(folder) / name).string());
}

void RunOutputs::add_files(const std::string& folder, const std::vector<std::string>& bodies,
                           const std::vector<const char*>& names) {
  if (folder.empty()) return;
  for (const std::string& body : bodies) add_files((fs::path(folder) / body).string(), names);
}

Status RunOutputs::check(const std::vector<NamedFile>& inputs) const {
  std::vector<std::string> outputs = named_;
  outputs.insert(outputs.end(), in_folders_.begin(), in_folders_.end());
  std::unordered_set<std::string> known;
  for (const std::string& path : in_folders_) known.insert(fs::path(path).lexically_normal());
  // Files of earlier runs, which are removed, and surfaces, which may be overwritten.
  std::vector<std::string> there;
  for (const EarlierRun& earlier : earlier_)
    there.insert(there.end(), earlier.files().begin(), earlier.files().end());
  for (const std::string& folder : folders_)
    for (std::string& path : files_like(folder, is_frame_name)) there.push_back(std::move(path));
  for (const std::string& path : there)
    if (known.insert(fs::path(path).lexically_normal()).second) outputs.push_back(path);
  if (Status s = keep_apart(outputs, inputs); !s) return s;
  if (Status s = check_writable(named_); !s) return s;
  return check_writable(in_folders_, true);
}

Status RunOutputs::remove_earlier(const std::vector<std::string>& written) const {
  for (const EarlierRun& earlier : earlier_)
    if (Status s = earlier.remove(written); !s) return s;
  return Success{};
}

const std::vector<const char*>& body_files() {
  static const std::vector<const char*> kNames = {kTableName, kEnergyPageName, kFramesName,
                                                  kMaterialsName};
  return kNames;
}

RunOutputs outputs_of(const std::vector<BodyScene>& bodies) {
  RunOutputs outputs;
  std::map<std::string, std::vector<std::string>> folders;
  for (const BodyScene& one : bodies) {
    outputs.add(one.file.outputs.wav);
    outputs.add(one.file.outputs.save);
    if (!one.file.outputs.out.empty())
      folders[folder_of_all(one, bodies)].push_back(one.body().name);
  }
  for (const auto& [folder, names] : folders)
    outputs.add_folder(folder, bodies.size() > 1 ? names : std::vector<std::string>());
  for (const BodyScene& one : bodies) {
    outputs.add_files(one.file.outputs.out, body_files());
    outputs.add_files(one.file.outputs.out, {kReportName});
  }
  if (bodies.size() > 1)
    for (const auto& [folder, names] : folders) outputs.add_files(folder, {kReportName});
  return outputs;
}

std::string folder_of_all(const BodyScene& body, const std::vector<BodyScene>& bodies) {
  const std::string& out = body.file.outputs.out;
  return bodies.size() > 1 ? fs::path(out).parent_path().string() : out;
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
