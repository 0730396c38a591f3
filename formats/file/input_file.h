// Opens the files that a user names; only regular files are read.
#pragma once

#include <cstdint>
#include <string>
#include <sys/stat.h>

#include "common/result.h"

namespace tremolo {

// A pipe may never send anything, a device never end: both are refused, as folders and sockets are,
// with what stands at the path. Symbolic links are followed. Errors are kSystem and name the path.

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
