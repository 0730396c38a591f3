// The bytes of a VTU file's arrays: inside their elements or appended, raw or base64, compressed or
// not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace tremolo {

// The compressed blocks of a VTU array.

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

// A file whose arrays are read: the XML with the attributes of its root, and the appended bytes.
struct VtuDocument {
  pugi::xml_document xml;
  std::string path;
  bool swap = false;         // the numbers have the other byte order than this machine
  bool long_header = false;  // sizes before the data are u64 rather than u32
  VtuCompression compression = VtuCompression::kNone;
  std::string_view appended;     // after the underscore; empty: none
  bool appended_base64 = false;  // raw otherwise
  std::size_t most_numbers = 0;  // an array has no more: a bound of the memory that it takes
  bool partitioned = false;      // a PUnstructuredGrid, whose pieces are files

  pugi::xml_node root() const { return xml.child("VTKFile"); }
};

// Parses the XML of `text`, which must outlive the document. Errors: kContent.
Status open_vtu(std::string_view text, const std::string& path, VtuDocument& document);

// `count` numbers of a DataArray; shown: its name in errors. Errors: kContent.
Status read_vtu_array(const VtuDocument& document, pugi::xml_node node, const std::string& shown,
                      std::size_t count, std::vector<std::int64_t>& values);
Status read_vtu_array(const VtuDocument& document, pugi::xml_node node, const std::string& shown,
                      std::size_t count, std::vector<double>& values);

}  // namespace tremolo
