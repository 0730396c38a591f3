#include "formats/file/whole_file.h"

#include "formats/file/mapped_file.h"

namespace tremolo {

Result<std::string> read_whole_file(const std::string& path) {
  const Result<MappedFile> file = MappedFile::open(path);
  if (!file) return file.error();
  const auto bytes = file->bytes();
  if (bytes.empty()) return content_error(path + ": the file is empty");
  // A copy, so that a file that changes while it is parsed cannot change under the parser.
  return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

}  // namespace tremolo
