#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <map>
#include <mutex>
#include <string_view>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

#include "formats/file/atomic_file.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMark = ".partial-";
constexpr int kAttempts = 64;  // threads that may write one target at the same time

// 0, or the error.
int lock(int descriptor) {
  while (::flock(descriptor, LOCK_EX | LOCK_NB) != 0)
    if (errno != EINTR) return errno;
  return 0;
}

bool has_name(int descriptor) {
  struct stat status = {};
  return ::fstat(descriptor, &status) == 0 && status.st_nlink > 0;
}

// NAME.partial-123 or NAME.partial-123-2
bool is_partial(std::string_view name) {
  const std::size_t mark = name.rfind(kMark);
  if (mark == std::string_view::npos || mark == 0) return false;
  const std::string_view owner = name.substr(mark + kMark.size());
  return !owner.empty() && std::all_of(owner.begin(), owner.end(),
                                       [](char c) { return (c >= '0' && c <= '9') || c == '-'; });
}

std::vector<std::string> partials_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
    if (std::string name = at->path().filename().string(); is_partial(name))
      names.push_back(std::move(name));
  return names;
}

void remove_unlocked(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_NOFOLLOW | O_CLOEXEC);
  if (descriptor < 0) return;
  struct stat status = {};
  if (::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) && lock(descriptor) == 0)
    ::unlink(path.c_str());
  ::close(descriptor);
}

}  // namespace

PartialFile create_partial(const std::string& target) {
  const std::string base = target + std::string(kMark) + std::to_string(::getpid());
  for (int attempt = 1; attempt <= kAttempts;) {
    PartialFile file{attempt == 1 ? base : base + "-" + std::to_string(attempt)};
    file.descriptor = ::open(file.path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file.descriptor < 0) {
      if (errno == EINTR) continue;
      if (errno != EEXIST) return file;
    } else if (lock(file.descriptor) != EWOULDBLOCK && has_name(file.descriptor)) {
      return file;
    } else {
      // Somebody took it for a stale one between our two calls.
      ::close(file.descriptor);
    }
    ++attempt;
  }
  errno = EEXIST;
  return {base};
}

int open_partial(const std::string& path) {
  int descriptor = -1;
  do {
    descriptor = ::open(path.c_str(), O_WRONLY | O_NOFOLLOW | O_CLOEXEC);
  } while (descriptor < 0 && errno == EINTR);
  if (descriptor < 0) return -1;
  (void)lock(descriptor);
  if (::lseek(descriptor, 0, SEEK_END) >= 0) return descriptor;
  const int error = errno;
  ::close(descriptor);
  errno = error;
  return -1;
}

void remove_stale_partials(const std::string& target) {
  static std::mutex mutex;
  static std::map<std::string, std::vector<std::string>> seen;
  const fs::path path(target);
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const std::string prefix = path.filename().string() + std::string(kMark);
  std::vector<std::string> stale;
  {
    const std::lock_guard guard(mutex);
    const auto [found, first] = seen.try_emplace(folder.string());
    if (first) found->second = partials_in(folder);
    std::erase_if(found->second, [&](const std::string& name) {
      const bool ours = name.starts_with(prefix);
      if (ours) stale.push_back((folder / name).string());
      return ours;
    });
  }
  for (const std::string& name : stale) remove_unlocked(name);
}

}  // namespace tremolo
