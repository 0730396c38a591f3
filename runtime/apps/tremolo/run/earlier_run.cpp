#include "runtime/apps/tremolo/run/earlier_run.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <unordered_set>

#include <nlohmann/json.hpp>

#include "formats/file/output_guard.h"
#include "runtime/apps/tremolo/output/plot.h"
#include "runtime/apps/tremolo/run/run_files.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;
using ReportJson = nlohmann::json;

constexpr std::string_view kFramesHead = "frame,t,file\n";

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(fs::symlink_status(path, ignored));
}

// The first bytes of a file.
std::string head_of(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string head(64, '\0');
  stream.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(stream.gcount()));
  return head;
}

// True if the file begins as this program's surface writers begin a file.
bool is_our_surface(const fs::path& path) {
  const std::string head = head_of(path), ending = path.extension().string();
  if (ending == ".ply") return head.starts_with("ply\nformat binary_little_endian 1.0\n");
  if (ending == ".obj") return head.starts_with("v ") || head.starts_with("mtllib surface.mtl\n");
  return head.starts_with("#declare Surface = mesh2 {\n");
}

// The names in the third column of frames.csv.
std::set<std::string> listed_frames(const fs::path& list) {
  std::set<std::string> names;
  if (!is_file(list) || !head_of(list).starts_with(kFramesHead)) return names;
  std::ifstream stream(list);
  for (std::string line; std::getline(stream, line);)
    names.insert(line.substr(line.rfind(',') + 1));
  return names;
}

bool has_time(std::string_view name) {
  return name.find("-t") != std::string_view::npos;
}

// report.json of a run; null if the file is not such a report.
ReportJson report_in(const fs::path& folder) {
  const fs::path path = folder / kReportName;
  if (!is_file(path)) return nullptr;
  std::ifstream stream(path);
  ReportJson report = ReportJson::parse(stream, nullptr, false);
  const bool ours = report.is_object() && report.contains("exit_code") &&
                    report.contains("reached") && report.contains("duration");
  // Of several bodies it holds the reports of all.
  const bool of_several = report.is_object() && report.contains("bodies") &&
                          report.size() == (report.contains("schema") ? 2U : 1U);
  return ours || of_several ? std::move(report) : ReportJson(nullptr);
}

// The folders of the bodies that a report lists, and its part about each.
std::vector<std::pair<std::string, ReportJson>> folders_of(const ReportJson& report) {
  std::vector<std::pair<std::string, ReportJson>> names;
  for (const auto& [list, key] : {std::pair{"bodies", "body"}, {"cloths", "cloth"}}) {
    const auto found = report.find(list);
    if (found == report.end() || !found->is_array()) continue;
    for (const ReportJson& entry : *found) {
      if (!entry.is_object() || !entry.contains(key) || !entry[key].is_string()) continue;
      const std::string name = entry[key];
      if (!name.empty() && name.front() != '.' && name.find('/') == std::string::npos)
        names.emplace_back(name, entry);
    }
  }
  return names;
}

}  // namespace

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

void EarlierRun::add(const std::string& path) {
  files_.push_back(fs::path(path).lexically_normal().string());
}

// reported: a report.json says that the folder is that of a run, or of one of its bodies.
void EarlierRun::look_into(const std::string& folder, bool reported) {
  const fs::path where(folder);
  const std::set<std::string> frames = listed_frames(where / kFramesName);
  const bool has_table =
      is_file(where / kTableName) && head_of(where / kTableName).starts_with("t,kinetic,");
  const auto ours = [&](const std::string& name) {
    const fs::path path = where / name;
    if (is_frame_name(name))
      return (has_time(name) || frames.contains(name)) && is_our_surface(path);
    if (name == kFramesName) return head_of(path).starts_with(kFramesHead);
    if (name == kMaterialsName) return head_of(path).starts_with("# names and mean colours");
    // `tremolo-precompute reference` has a table of that name and no report.
    if (name == kTableName) return reported && has_table;
    const bool was_run = reported || has_table;
    return was_run && (name == "energy.svg" || name == kEnergyPageName || name == kReportName);
  };
  for (const std::string& path : files_like(folder, [](std::string_view) { return true; }))
    if (is_file(path) && ours(fs::path(path).filename().string())) add(path);
}

EarlierRun EarlierRun::in(const std::string& folder, const std::vector<std::string>& bodies) {
  EarlierRun earlier;
  std::error_code ignored;
  if (folder.empty() || !fs::is_directory(folder, ignored)) return earlier;
  const ReportJson report = report_in(folder);
  earlier.look_into(folder, report.is_object());
  std::set<std::string> looked;
  for (const std::string& name : bodies) {
    const std::string one = (fs::path(folder) / name).string();
    if (looked.insert(name).second && fs::is_directory(one, ignored))
      earlier.look_into(one, report.is_object());
  }
  for (const auto& [name, said] : folders_of(report)) {
    const fs::path one = fs::path(folder) / name;
    if (looked.contains(name) || !fs::is_directory(fs::symlink_status(one, ignored))) continue;
    looked.insert(name);
    // Somebody has made another run into it since.
    if (const ReportJson own = report_in(one); own.is_object() && own != said) continue;
    earlier.look_into(one.string(), true);
    earlier.old_bodies_.push_back(one.string());
  }
  return earlier;
}

Status EarlierRun::remove(const std::vector<std::string>& written) const {
  std::unordered_set<std::string> kept;
  for (const std::string& path : written) kept.insert(fs::path(path).lexically_normal().string());
  for (const std::string& path : files_)
    if (!kept.contains(path))
      if (Status s = remove_result(path); !s) return s;
  // A folder that holds something else stays.
  std::error_code not_empty;
  for (const std::string& folder : old_bodies_) fs::remove(folder, not_empty);
  return Success{};
}

}  // namespace tremolo
