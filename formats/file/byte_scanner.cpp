#include "formats/file/byte_scanner.h"

#include <utility>

namespace tremolo {

ByteScanner::ByteScanner(std::string_view bytes, std::string file, std::size_t offset, bool swap)
    : bytes_(bytes),
      file_(std::move(file)),
      at_(std::min(offset, bytes.size())),
      last_(at_),
      swap_(swap) {}

bool ByteScanner::fits(std::size_t count, std::size_t size, std::string_view what) {
  if (size == 0 || count <= remaining() / size) return true;
  last_ = at_;
  error_ =
      problem("expected " + (count == 1 ? "" : std::to_string(count) + " ") + std::string(what) +
              " (" + std::to_string(size) + (count == 1 ? " bytes)" : " bytes each)") +
              ", found only " + std::to_string(remaining()) + " bytes before the end of the file");
  return false;
}

bool ByteScanner::skip(std::size_t count, std::size_t size, std::string_view what) {
  if (!fits(count, size, what)) return false;
  at_ += count * size;
  return true;
}

Error ByteScanner::problem(const std::string& text) const {
  return content_error(file_ + ", byte " + std::to_string(last_) + ": " + text);
}

}  // namespace tremolo
