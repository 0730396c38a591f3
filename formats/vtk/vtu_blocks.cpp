#include <limits>
#include <lz4.h>
#include <zlib.h>

#include "formats/vtk/vtu_data.h"

namespace tremolo {
namespace {

// Whether `from` decompresses to exactly `size` bytes at `to`.
bool inflate_block(std::string_view from, char* to, std::size_t size) {
  if (from.size() > std::numeric_limits<uLong>::max() / 2) return false;
  uLongf written = size;
  const int code = uncompress(reinterpret_cast<Bytef*>(to), &written,
                              reinterpret_cast<const Bytef*>(from.data()), from.size());
  return code == Z_OK && written == size;
}

bool expand_lz4(std::string_view from, char* to, std::size_t size) {
  constexpr std::size_t kMost = std::numeric_limits<int>::max();
  if (from.size() > kMost || size > kMost) return false;
  const int written =
      LZ4_decompress_safe(from.data(), to, static_cast<int>(from.size()), static_cast<int>(size));
  return written >= 0 && static_cast<std::size_t>(written) == size;
}

}  // namespace

Result<std::string> decompress_blocks(VtuCompression compression, const VtuBlocks& blocks,
                                      std::string_view bytes, const std::string& place) {
  std::string data(blocks.size(), '\0');
  std::size_t from = 0;
  std::size_t to = 0;
  for (std::size_t b = 0; b < blocks.compressed.size(); ++b) {
    const bool is_last = b + 1 == blocks.compressed.size();
    const std::size_t size = is_last && blocks.last != 0 ? blocks.last : blocks.block;
    const std::size_t taken = blocks.compressed[b];
    const bool held = taken <= bytes.size() - from;
    const std::string_view block = held ? bytes.substr(from, taken) : std::string_view();
    const bool good =
        held && (compression == VtuCompression::kZlib ? inflate_block(block, data.data() + to, size)
                                                      : expand_lz4(block, data.data() + to, size));
    if (!good)
      return content_error(place + ": expected block " + std::to_string(b) + " of " +
                           std::to_string(taken) + " bytes to decompress to " +
                           std::to_string(size) + " bytes, found that it is " +
                           (held ? "damaged" : "cut off"));
    from += taken;
    to += size;
  }
  return data;
}

}  // namespace tremolo
