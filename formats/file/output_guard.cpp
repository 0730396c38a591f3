#include "formats/file/output_guard.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string_view>
#include <sys/stat.h>
#include <unistd.h>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "common/result.h"
#include "common/text.h"
#include "formats/file/atomic_file.h"
#include "formats/file/input_file.h"
#include "formats/file/named_below.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;
using Inode = std::pair<dev_t, ino_t>;

// Resolves paths: absolute, with links followed as far as files exist. Each folder is resolved
// once, so that many files in many folders are cheap.
class Places {
 public:
  // Empty if that fails.
  std::string of(const fs::path& path) {
    std::error_code error;
    const fs::path absolute = path.is_absolute() ? path : current() / path;
    const fs::path name = absolute.filename();
    if (name.empty() || name == "." || name == "..") return folder(absolute).place;
    const Folder& parent = folder(absolute.parent_path());
    if (parent.place.empty()) return {};
    if (parent.there && fs::is_symlink(parent.place + "/" + name.string(), error))
      return fs::weakly_canonical(absolute, error).string();
    return (parent.place == "/" ? "/" : parent.place + "/") + name.string();
  }
  // stat() of a path if its folder exists; false if there is nothing.
  bool look(const std::string& path, struct stat& status) {
    const fs::path absolute = fs::path(path).is_absolute() ? fs::path(path) : current() / path;
    return folder(absolute.parent_path()).there && ::stat(path.c_str(), &status) == 0;
  }

 private:
  struct Folder {
    std::string place;
    bool there = false;
  };

  const fs::path& current() {
    std::error_code error;
    if (current_.empty()) current_ = fs::current_path(error);
    return current_;
  }

  // The result is valid until the next call.
  const Folder& folder(const fs::path& path) {
    const auto found = folders_.find(path.string());
    if (found != folders_.end()) return found->second;
    return folders_[path.string()] = look_up(path);
  }

  Folder look_up(const fs::path& path) {
    std::error_code error;
    const fs::path name = path.filename();
    const bool plain = !name.empty() && name != "." && name != ".." && path.has_parent_path();
    if (plain && path != path.root_path()) {
      // Nothing exists below a missing folder.
      const Folder parent = folder(path.parent_path());
      const std::string place = (parent.place == "/" ? "/" : parent.place + "/") + name.string();
      if (parent.place.empty()) return {};
      if (!parent.there || !fs::exists(fs::symlink_status(place, error))) return {place, false};
    }
    if (const fs::path real = fs::canonical(path, error); !error) return {real.string(), true};
    const fs::path known = fs::weakly_canonical(path, error);
    if (error) return {};
    // A path that ends in "." or ".." is returned with a trailing slash.
    return {(known.has_filename() ? known : known.parent_path()).string(), false};
  }

  fs::path current_;
  std::unordered_map<std::string, Folder> folders_;
};

bool lies_in(const fs::path& file, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first ==
         folder.end();
}

// Formats that refer to files contain their names as on the disk.
bool holds_text(const std::string& path, std::string_view text) {
  const Result<MappedFile> file = MappedFile::open(path);
  if (!file) return false;  // its reader reports the error
  const auto bytes = file->bytes();
  return std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()).find(text) !=
         std::string_view::npos;
}

// Files that an Abaqus file names behind INPUT=, on lines that begin with a star.
std::vector<std::string> included_by(const std::string& path) {
  std::vector<std::string> included;
  const Result<MappedFile> file = MappedFile::open(path);
  if (!file) return included;
  const auto bytes = file->bytes();
  std::string_view rest(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  while (!rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(rest.size(), line.size() + 1));
    if (!line.starts_with('*')) continue;
    const std::size_t at = upper_case(line).find("INPUT=");
    if (at == std::string::npos) continue;
    std::string name(line.substr(at + 6, line.find(',', at) - at - 6));
    std::erase_if(name, [](char c) { return c == '"' || c == '\r' || c == ' ' || c == '\t'; });
    if (const auto below = named_below(path, name)) included.push_back(*below);
  }
  return included;
}

// True if the file at `place` is one of those that this file includes, or that they include. seen:
// files that are known already.
bool is_included(const fs::path& place, const std::string& path, std::set<fs::path>& seen) {
  for (const std::string& name : included_by(path)) {
    std::error_code code;
    const fs::path next = fs::weakly_canonical(name, code);
    if (next == place) return true;
    if (seen.insert(next).second && is_included(place, name, seen)) return true;
  }
  return false;
}

// True if an existing output, at `place`, belongs to the input.
bool is_named_by(const fs::path& place, const NamedFile& input, const fs::path& owner) {
  if (owner.empty() || !lies_in(place, owner.parent_path())) return false;
  const std::string extension = owner.extension().string();
  if ((extension == ".node" || extension == ".ele") && place.stem() == owner.stem() &&
      (place.extension() == ".node" || place.extension() == ".ele"))
    return true;
  if (holds_text(input.path, place.filename().string())) return true;
  std::set<fs::path> seen;
  return extension == ".inp" && is_included(place, input.path, seen);
}

Error taken(const std::string& output, const std::string& whose) {
  return {ErrorKind::kUsage, output + ": the output would take the place of " + whose};
}

std::string whose_text(const NamedFile& input) {
  return input.path + " (" + input.role + ")";
}

// Inputs by inode and by resolved path.
class KnownInputs {
 public:
  KnownInputs(const std::vector<NamedFile>& inputs, Places& places) {
    for (const NamedFile& input : inputs) {
      if (input.path.empty()) continue;
      const std::string place = places.of(input.path);
      if (input.names_others) owners_.emplace_back(input, place);
      if (!place.empty()) by_place_.try_emplace(place, input);
      struct stat status = {};
      if (::stat(input.path.c_str(), &status) == 0)
        by_inode_.try_emplace(Inode(status.st_dev, status.st_ino), input);
    }
  }

  // status: of the existing file; null: there is none.
  Status keep(const std::string& output, const std::string& place,
              const struct stat* status) const {
    if (const auto found = by_place_.find(place); found != by_place_.end())
      return taken(output, whose_text(found->second));
    if (status == nullptr) return Success{};
    const auto found = by_inode_.find(Inode(status->st_dev, status->st_ino));
    if (found != by_inode_.end()) return taken(output, whose_text(found->second));
    for (const auto& [input, owner] : owners_)
      if (is_named_by(place, input, owner))
        return taken(output, "a file that belongs to " + whose_text(input));
    return Success{};
  }

 private:
  std::unordered_map<std::string, NamedFile> by_place_;
  std::map<Inode, NamedFile> by_inode_;
  std::vector<std::pair<NamedFile, fs::path>> owners_;
};

// Outputs by resolved path and, if they exist, by inode.
class KnownOutputs {
 public:
  Status add(const std::string& output, const std::string& place, const struct stat* status) {
    if (place.empty()) return Success{};
    if (const auto [other, is_new] = by_place_.try_emplace(place, output); !is_new)
      return twice(output, other->second);
    if (status == nullptr) return Success{};
    const auto [other, is_new] =
        by_inode_.try_emplace(Inode(status->st_dev, status->st_ino), output);
    return is_new ? Status(Success{}) : twice(output, other->second);
  }

  // An error if one output would have to be a folder for another one.
  Status check_folders() const {
    std::unordered_set<std::string> seen;
    for (const auto& [place, output] : by_place_) {
      fs::path folder = fs::path(place).parent_path();
      for (; seen.insert(folder.string()).second; folder = folder.parent_path())
        if (const auto file = by_place_.find(folder.string()); file != by_place_.end())
          return Error{ErrorKind::kUsage, file->second + ": the output would have to be a folder " +
                                              "too, for the output " + output};
    }
    return Success{};
  }

 private:
  static Error twice(const std::string& output, const std::string& other) {
    return {ErrorKind::kUsage, output + ": two outputs of this name, the other is " + other};
  }

  std::unordered_map<std::string, std::string> by_place_;
  std::map<Inode, std::string> by_inode_;
};

std::mutex guard_mutex;
std::unique_ptr<const KnownInputs> guarded;

// The nearest folder above the path that is there.
fs::path nearest_folder(const fs::path& path) {
  std::error_code error;
  fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  while (!fs::exists(fs::symlink_status(folder, error)) && folder.has_parent_path() &&
         folder != folder.parent_path())
    folder = folder.parent_path();
  return fs::exists(fs::symlink_status(folder, error)) ? folder : fs::path(".");
}

// Checks that the output's folders can be created, by creating a file where the first of them would
// be.
Status check_new_folders(const std::string& output) {
  const fs::path there = nearest_folder(output);
  std::error_code error;
  if (!fs::is_directory(there, error))
    return system_error(output + ": cannot write: " + there.string() + " is not a folder");
  for (const fs::path& name : fs::path(output))
    if (name.string().size() > 255)
      return system_error(output + ": cannot write: " + std::strerror(ENAMETOOLONG));
  const PartialFile trial = create_partial((there / "tremolo").string());
  if (trial.descriptor < 0)
    return os_error(output + ": cannot create a folder in " + there.string());
  ::close(trial.descriptor);
  ::unlink(trial.path.c_str());
  return Success{};
}

}  // namespace

bool same_file(const std::string& a, const std::string& b) {
  std::error_code error;
  if (fs::equivalent(a, b, error) && !error) return true;
  Places places;
  const std::string first = places.of(a);
  return !first.empty() && first == places.of(b);
}

Status keep_apart(const std::vector<std::string>& outputs, const std::vector<NamedFile>& inputs) {
  Places places;
  const KnownInputs known(inputs, places);
  KnownOutputs seen;
  for (const std::string& output : outputs) {
    if (output.empty()) continue;
    const std::string place = places.of(output);
    struct stat status = {};
    const struct stat* there = places.look(output, status) ? &status : nullptr;
    if (Status s = known.keep(output, place, there); !s) return s;
    if (Status s = seen.add(output, place, there); !s) return s;
  }
  return seen.check_folders();
}

Status check_writable(const std::vector<std::string>& outputs, bool makes_folders) {
  std::set<std::string> tried;
  for (const std::string& output : outputs) {
    if (output.empty()) continue;
    std::error_code error;
    const fs::path path(output);
    const std::string folder = path.has_parent_path() ? path.parent_path().string() : ".";
    const fs::file_status status = fs::status(path, error);
    if (fs::exists(status) && !fs::is_regular_file(status))
      return system_error(output + ": cannot write: it exists and is not a regular file");
    // One trial per folder is enough.
    if (makes_folders && !tried.insert(folder).second) continue;
    if (makes_folders && !fs::exists(folder, error)) {
      if (Status s = check_new_folders(output); !s) return s;
      continue;
    }
    if (const Result<AtomicFile> trial = AtomicFile::create(output); !trial) return trial.error();
  }
  return Success{};
}

std::vector<std::string> files_like(const std::string& folder,
                                    const std::function<bool(std::string_view)>& matches) {
  std::vector<std::string> files;
  std::error_code error;
  const fs::path where = folder.empty() ? fs::path(".") : fs::path(folder);
  for (fs::directory_iterator at(where, error), end; !error && at != end; at.increment(error))
    if (const fs::path name = at->path().filename(); matches(name.string()))
      files.push_back((fs::path(folder) / name).string());
  return files;
}

GuardedInputs::GuardedInputs(const std::vector<NamedFile>& inputs) {
  Places places;
  auto known = std::make_unique<const KnownInputs>(inputs, places);
  const std::lock_guard hold(guard_mutex);
  guarded = std::move(known);
}

GuardedInputs::~GuardedInputs() {
  const std::lock_guard hold(guard_mutex);
  guarded.reset();
}

Status check_replaceable(const std::string& output) {
  const std::lock_guard hold(guard_mutex);
  if (!guarded) return Success{};
  Places places;
  struct stat status = {};
  const bool there = ::stat(output.c_str(), &status) == 0;
  return guarded->keep(output, places.of(output), there ? &status : nullptr);
}

Status remove_result(const std::string& path) {
  if (Status s = check_replaceable(path); !s) return s;
  std::error_code error;
  std::filesystem::remove(path, error);
  if (error) return system_error(path + ": cannot remove: " + error.message());
  return Success{};
}

}  // namespace tremolo
