#include "runtime/apps/tremolo/run/log_files.h"

#include <cmath>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "runtime/apps/tremolo/run/run_files.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPiece = std::size_t{1} << 16;  // bytes; a write a few hundred rows

}  // namespace

Status make_run_folder(const std::string& folder) {
  if (folder.empty()) return Success{};
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return system_error(folder + ": cannot create: " + error.message());
  return Success{};
}

SceneOutputs outputs_of_body(const SceneOutputs& all, const std::string& body) {
  SceneOutputs outputs = all;
  if (!all.out.empty()) outputs.out = (fs::path(all.out) / body).string();
  return outputs;
}

std::string table_path(const SceneOutputs& outputs) {
  return outputs.out.empty() ? std::string() : (fs::path(outputs.out) / kTableName).string();
}

Result<CsvTable> CsvTable::create(const std::string& path, std::string head, bool parked) {
  CsvTable table;
  if (path.empty()) return table;
  table.text_ = std::move(head) + '\n';
  table.parked_ = parked;
  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file) return file.error();
  table.file_ = std::make_unique<AtomicFile>(std::move(*file));
  if (parked) table.file_->park();
  return table;
}

Status CsvTable::end_row() {
  text_ += '\n';
  return text_.size() < kPiece ? Status(Success{}) : flush();
}

Status CsvTable::flush() {
  if (!file_ || text_.empty()) return Success{};
  const Status status = file_->write(text_);
  text_.clear();
  if (parked_) file_->park();
  return status;
}

Status CsvTable::finish() {
  if (!file_) return Success{};
  if (Status status = flush(); !status) return status;
  return file_->commit();
}

Frames::Frames(const SceneOutputs& outputs, StepRange steps)
    : folder_(outputs.out),
      format_(outputs.surface_format),
      count_(outputs.out.empty() ? 0 : outputs.surfaces),
      steps_(steps.last) {
  while (steps.first > 0 && due(steps.first)) ++next_;
}

bool Frames::due(std::int64_t steps) const {
  if (next_ >= count_) return false;
  return steps >= std::llround(static_cast<double>(steps_) * (next_ + 1) / count_);
}

Status Frames::write(double time, const std::function<Status(const std::string& path)>& write) {
  const std::string name = frame_name(next_, time, format_);
  const std::string path = (fs::path(folder_) / name).string();
  list_ += fmt::format("{},{:.9g},{}\n", next_, time, name);
  ++next_;
  if (Status s = write(path); !s) return s;
  files_.push_back(path);
  return Success{};
}

Status Frames::finish() {
  if (files_.empty()) return Success{};
  const std::string list = (fs::path(folder_) / kFramesName).string();
  if (Status s = write_file(list, list_); !s) return s;
  files_.push_back(list);
  return Success{};
}

Status finish_files(const SceneOutputs& outputs, Frames& frames, CsvTable& table,
                    std::vector<std::string>& files) {
  if (!table.is_written()) return Success{};
  if (Status s = frames.finish(); !s) return s;
  files.insert(files.end(), frames.files().begin(), frames.files().end());
  if (Status s = table.finish(); !s) return s;
  files.push_back(table_path(outputs));
  return Success{};
}

}  // namespace tremolo
