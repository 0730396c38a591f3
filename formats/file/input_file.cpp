#include "formats/file/input_file.h"

#include <fcntl.h>
#include <unistd.h>

#include "formats/file/os_error.h"

namespace tremolo {
namespace {

const char* kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a pipe: write to a file what comes through it, and name that";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

Error not_regular(const std::string& path, mode_t mode) {
  return system_error(path + ": not a regular file but " + kind_of(mode));
}

Error failure(const std::string& path, const char* what) {
  return os_error(path + ": cannot " + what);
}

}  // namespace

Result<struct stat> examine_input(const std::string& path) {
  struct stat status = {};
  if (::stat(path.c_str(), &status) != 0) return failure(path, "open");
  if (!S_ISREG(status.st_mode)) return not_regular(path, status.st_mode);
  return status;
}

Result<InputFile> open_input(const std::string& path) {
  const Result<struct stat> seen = examine_input(path);
  if (!seen) return seen.error();
  // O_NONBLOCK, because the path may lead to another kind of file meanwhile.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (descriptor < 0) return failure(path, "open");
  struct stat status = {};
  if (::fstat(descriptor, &status) != 0) {
    const Error error = failure(path, "examine");
    ::close(descriptor);
    return error;
  }
  if (!S_ISREG(status.st_mode)) {
    ::close(descriptor);
    return not_regular(path, status.st_mode);
  }
  return InputFile{descriptor, static_cast<std::uint64_t>(status.st_size)};
}

}  // namespace tremolo
