#include "runtime/program/checksum.h"

#include <span>

#include "common/hash.h"
#include "formats/whole_file.h"

namespace tremolo {

std::string checksum(std::string_view bytes) {
  return hash_text(hash_bytes(std::as_bytes(std::span(bytes))));
}

Result<std::string> program_checksum() {
  const Result<std::string> program = read_whole_file("/proc/self/exe");
  if (!program) return program.error();
  return checksum(*program);
}

}  // namespace tremolo
