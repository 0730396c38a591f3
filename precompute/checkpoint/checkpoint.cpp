#include "precompute/checkpoint/checkpoint.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include "common/hash.h"
#include "formats/file/atomic_file.h"
#include "precompute/ranks/rank_agreement.h"
#include "precompute/system/failure.h"
#include "precompute/system/petsc.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

constexpr const char* kIdentity = "identity";
constexpr const char* kTogether = "together";

std::string file_name(const std::string& stage, int rank) {
  return stage + "." + std::to_string(rank);
}

// Returns whether the name is STAGE.RANK for any stage and rank.
bool is_stage_file(const std::string& name) {
  static const std::vector<std::string> stages = {"modes", "derivatives", "certificate", "basis",
                                                  "coefficients"};
  const std::size_t dot = name.rfind('.');
  if (dot == std::string::npos || dot + 1 == name.size()) return false;
  return std::find(stages.begin(), stages.end(), name.substr(0, dot)) != stages.end() &&
         std::all_of(name.begin() + dot + 1, name.end(),
                     [](char c) { return c >= '0' && c <= '9'; });
}

// Returns whether the file is one of this rank.
bool is_own_stage_file(const std::string& name) {
  return is_stage_file(name) && name.ends_with("." + std::to_string(mpi_rank()));
}

std::vector<std::string> names_in(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
    names.push_back(at->path().filename().string());
  return names;
}

// Removes the stages of all ranks and partial files left by killed processes.
void remove_stages(const std::string& folder) {
  std::error_code ignored;
  for (const std::string& name : names_in(folder)) {
    const std::size_t mark = name.find(".partial-");
    if (mark != std::string::npos && is_stage_file(name.substr(0, mark)))
      remove_stale_partials((fs::path(folder) / name.substr(0, mark)).string());
    if (is_stage_file(name)) fs::remove(fs::path(folder) / name, ignored);
  }
}

// Returns a hash over all ranks, which identifies files that were written together.
std::int64_t hash_over_ranks(const std::vector<NamedArray>& arrays) {
  if (mpi_ranks() == 1) return 0;
  std::uint64_t sum = 0;
  for (const NamedArray& array : arrays) sum = 3 * sum + hash_bytes(array.bytes);
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, PETSC_COMM_WORLD);
  return sum;
}

bool same_on_all_ranks(std::int64_t value) {
  std::int64_t least = value, most = value;
  MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPI_INT64_T, MPI_MIN, PETSC_COMM_WORLD);
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_INT64_T, MPI_MAX, PETSC_COMM_WORLD);
  return least == most;
}

std::string as_text(const CheckpointIdentity& identity) {
  std::string text;
  for (const auto& [name, value] : identity)
    text.append(name).append(": ").append(value).append("\n");
  return text;
}

std::map<std::string, std::string> as_map(const std::string& text) {
  std::map<std::string, std::string> entries;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    const std::size_t colon = std::min(line.find(": "), line.size());
    entries[line.substr(0, colon)] = colon < line.size() ? line.substr(colon + 2) : "";
    at = end + 1;
  }
  return entries;
}

// Makes text from an untrusted file safe for a terminal: at most 200 printable characters.
std::string printable(std::string text) {
  if (text.empty()) return "nothing";
  text.resize(std::min<std::size_t>(text.size(), 200));
  for (char& c : text)
    if (c < ' ' || c > '~') c = '?';
  return text;
}

// Returns for instance "linear modes (20 there, 30 here), mesh (...)".
std::string differences(const std::string& there, const CheckpointIdentity& here) {
  std::map<std::string, std::string> kept = as_map(there);
  std::string text;
  for (const auto& [name, value] : here) {
    if (kept[name] == value) continue;
    text.append(text.empty() ? "" : ", ").append(name).append(" (").append(printable(kept[name]));
    text.append(" there, ").append(value).append(" here)");
  }
  return text.empty() ? "they have further entries" : text;
}

}  // namespace

std::string checkpoint_folder(const std::string& output_path) {
  return output_path + ".checkpoint";
}

std::optional<LinearSolver> kept_solver(const CheckpointRequest& request) {
  if (!request.resume) return std::nullopt;
  constexpr LinearSolver kSolvers[] = {LinearSolver::kCholmod, LinearSolver::kMumps,
                                       LinearSolver::kIterative};
  int found = -1;
  for (const std::string& name : names_in(request.folder)) {
    if (mpi_rank() != 0 || !is_stage_file(name)) continue;
    const auto file = CheckpointFile::open((fs::path(request.folder) / name).string());
    const Result<std::string> identity = file ? file->text(kIdentity) : file.error();
    if (!identity) continue;
    for (int i = 0; i < 3; ++i)
      if (as_map(*identity)[kSolverFact] == name_of(kSolvers[i])) found = i;
  }
  MPI_Bcast(&found, 1, MPI_INT, 0, PETSC_COMM_WORLD);
  // The stages are those of a run with one process: the number of ranks is the difference to
  // report.
  if (found >= 0 && kSolvers[found] == LinearSolver::kCholmod && mpi_ranks() > 1) found = -1;
  return found < 0 ? std::nullopt : std::optional(kSolvers[found]);
}

Checkpoint::Checkpoint(const CheckpointRequest& request, const CheckpointIdentity& identity,
                       StageLog& log)
    : folder_(request.folder), identity_(as_text(identity)), log_(log) {
  if (!request.keep) return;
  reading_ = request.resume;
  writing_ = true;
  if (reading_) {
    require_same_identity(identity);
  } else if (mpi_rank() == 0) {
    remove_stages(folder_);
  }
  make_folder();
}

void Checkpoint::require_same_identity(const CheckpointIdentity& identity) {
  std::string different;
  bool any = false;
  for (const std::string& name : names_in(folder_)) {
    // Files of other ranks may differ in processor and thread count, which are part of the
    // identity.
    if (!is_own_stage_file(name)) continue;
    any = true;
    const Result<CheckpointFile> file = CheckpointFile::open((fs::path(folder_) / name).string());
    if (!file) continue;  // reported when the stage is read
    const Result<std::string> text = file->text(kIdentity);
    if (text && *text != identity_) different = differences(*text, identity);
  }
  if (!any) log_.note("nothing to resume in " + folder_ + ": all stages are computed");
  std::optional<Error> refusal;
  if (!different.empty())
    refusal = content_error(folder_ + ": the stages in it belong to another run: " + different +
                            ". Resume with that run's options, or start again with --checkpoint "
                            "instead of --resume");
  fail_together(refusal);
}

void Checkpoint::make_folder() {
  std::error_code error;
  if (mpi_rank() == 0) fs::create_directory(folder_, error);
  std::error_code status_error;
  const bool there = true_on_all_ranks(mpi_rank() != 0 || fs::is_directory(folder_, status_error));
  if (!error) error = status_error;
  if (there) return;
  log_.note("warning: " + folder_ + ": cannot make the folder" +
            (error ? ": " + error.message() : "") + "; the run continues without checkpoints");
  writing_ = false;
}

std::string Checkpoint::path(const std::string& stage) const {
  return (fs::path(folder_) / file_name(stage, mpi_rank())).string();
}

// Opens this rank's file of a stage. Without a usable file `problem` is the reason; it is empty if
// no file exists.
std::optional<CheckpointFile> Checkpoint::open(const std::string& stage,
                                               std::string& problem) const {
  std::error_code ignored;
  if (!fs::exists(path(stage), ignored)) return std::nullopt;
  Result<CheckpointFile> file = CheckpointFile::open(path(stage));
  if (!file) {
    problem = file.error().message;
    return std::nullopt;
  }
  const Result<std::string> identity = file->text(kIdentity);
  if (identity && *identity == identity_) return std::move(*file);
  problem = identity ? path(stage) + ": belongs to another run" : identity.error().message;
  return std::nullopt;
}

bool Checkpoint::find(const std::string& stage,
                      const std::function<void(const CheckpointFile&)>& take) {
  if (!reading_) return false;
  std::string problem;
  const std::optional<CheckpointFile> file = open(stage, problem);
  std::int64_t together = 0;
  bool good = file.has_value();
  if (good) try {
      const std::vector<std::int64_t> one = unwrap(file->integers(kTogether));
      if (one.size() != 1) throw Failure(content_error("expected one number 'together'"));
      together = one[0];
      take(*file);
    } catch (const Failure& failure) {
      good = false;
      problem = failure.error().message;
      if (!problem.starts_with(path(stage))) problem = path(stage) + ": " + problem;
    }
  const bool none = true_on_all_ranks(!file && problem.empty());
  const bool all = true_on_all_ranks(good);
  if (all && same_on_all_ranks(together)) {
    found_ = true;
    return true;
  }
  if (none) return false;
  if (!good && problem.empty()) problem = path(stage) + ": the file is missing";
  const std::string message = first_text(problem);
  log_.note(
      (all ? folder_ + ": the files of stage '" + stage + "' belong to different runs" : message) +
      "; the stage is computed again");
  return false;
}

void Checkpoint::keep(const std::string& stage, std::vector<NamedArray> arrays) {
  if (!writing_) return;
  const std::vector<std::int64_t> together = {hash_over_ranks(arrays)};
  arrays.push_back(named_array(kIdentity, identity_));
  arrays.push_back(named_array(kTogether, together));
  const Status status = write_checkpoint_file(path(stage), arrays);
  writing_ = true_on_all_ranks(bool(status));
  if (writing_) return;
  const std::string problem = first_text(status ? "" : status.error().message);
  std::error_code ignored;
  fs::remove(path(stage), ignored);
  log_.note("warning: " + problem + "; the run continues without checkpoints");
}

void Checkpoint::drop(const std::string& stage) {
  std::error_code ignored;
  if (writing_) fs::remove(path(stage), ignored);
}

void remove_checkpoint(const CheckpointRequest& request, const StageLog& log) {
  if (!request.keep) return;
  const std::string folder = request.folder;
  remove_stages(folder);
  std::error_code error;
  // The folder's path may have been replaced by a file, or be a link to other storage: keep those.
  if (!fs::is_directory(fs::symlink_status(folder, error))) return;
  fs::remove(folder, error);
  if (error) log.note(folder + ": cannot remove the folder: " + error.message());
}

}  // namespace tremolo
