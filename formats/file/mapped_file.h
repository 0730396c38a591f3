// A whole file as read-only memory.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "common/result.h"

namespace tremolo {

// Maps a regular file. The bytes are valid as long as the object (or the one it was moved into)
// exists, provided that no process truncates the file meanwhile. Errors are kSystem with the path.
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

}  // namespace tremolo
