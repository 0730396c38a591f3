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
#include "formats/vtk/vtu_blocks.h"

namespace tremolo {

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
