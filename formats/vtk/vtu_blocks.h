// The compressed blocks of a VTU array.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace tremolo {

enum class VtuCompression { kNone, kZlib, kLz4 };

// Sizes before the blocks: of all data, and of each compressed block.
struct VtuBlocks {
  std::size_t block = 0;  // bytes of a block that is not the last, not compressed
  std::size_t last = 0;   // of the last; 0: it is as long as the others
  std::vector<std::size_t> compressed;

  // Bytes of all data, not compressed.
  std::size_t size() const {
    if (compressed.empty()) return 0;
    return last == 0 ? compressed.size() * block : (compressed.size() - 1) * block + last;
  }
};

// bytes: of all blocks in order. place: of the array, for errors (kContent). Memory is
// blocks.size(), which the caller has bounded.
Result<std::string> decompress_blocks(VtuCompression compression, const VtuBlocks& blocks,
                                      std::string_view bytes, const std::string& place);

}  // namespace tremolo
