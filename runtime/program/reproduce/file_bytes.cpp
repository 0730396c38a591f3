#include "runtime/program/reproduce/file_bytes.h"

#include <fstream>
#include <iterator>
#include <span>

#include "common/hash.h"

namespace tremolo::reproduce {

Result<std::string> file_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return system_error(path + ": cannot open");
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  if (file.bad()) return system_error(path + ": cannot read");
  return bytes;
}

std::string checksum(std::string_view bytes) {
  return hash_text(hash_bytes(std::as_bytes(std::span(bytes))));
}

}  // namespace tremolo::reproduce
