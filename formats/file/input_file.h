// Files that are read: opened, mapped into memory, copied whole, their checksums.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
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

// A whole file as read-only memory. Maps a regular file. The bytes are valid as long as the object
// (or the one it was moved into) exists, provided that no process truncates the file meanwhile.
// Errors are kSystem with the path.
class MappedFile {
 public:
  static Result<MappedFile> open(const std::string& path);

  MappedFile() = default;
  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&& other) noexcept;
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();

  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::span<const std::byte> bytes_;
};

// A whole file in memory, for the readers of mesh and text files. The bytes of a regular file,
// unchanged. Errors: kSystem if it cannot be opened or read or is not a regular file, kContent if
// it is empty; both name the path.
Result<std::string> read_whole_file(const std::string& path);

// Checksums as the program writes and compares them: XXH3-64, 16 hexadecimal digits.

std::string checksum(std::string_view bytes);

// The checksum of the running program's file, which distinguishes results of other builds. Errors:
// kSystem if the file cannot be read.
Result<std::string> program_checksum();

}  // namespace tremolo
