// Opens the files that a user names; only regular files are read.
#pragma once

#include <cstdint>
#include <string>
#include <sys/stat.h>

#include "common/result.h"

namespace tremolo {

// Only regular files are accepted: a pipe may never send anything, a device may never end. The
// error gives the kind of the file found. Symbolic links are followed. Errors are kSystem with the
// path.

// The result of stat() for a regular file. It opens nothing: opening a pipe waits for its writer,
// and some devices act when they are opened.
Result<struct stat> examine_input(const std::string& path);

// A descriptor for reading; the caller closes it. size: of the file when it was opened, bytes.
struct InputFile {
  int descriptor = -1;
  std::uint64_t size = 0;
};
Result<InputFile> open_input(const std::string& path);

}  // namespace tremolo
