#include "formats/file/checksum.h"

#include <span>

#include "common/hash.h"
#include "formats/file/mapped_file.h"

namespace tremolo {

std::string checksum(std::string_view bytes) {
  return hash_text(hash_bytes(std::as_bytes(std::span(bytes.data(), bytes.size()))));
}

Result<std::string> program_checksum() {
  const Result<MappedFile> program = MappedFile::open("/proc/self/exe");
  if (!program) return program.error();
  return hash_text(hash_bytes(program->bytes()));
}

}  // namespace tremolo
