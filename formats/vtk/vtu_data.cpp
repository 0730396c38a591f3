#include "formats/vtk/vtu_data.h"

#include <algorithm>
#include <bit>
#include <optional>
#include <type_traits>

#include "formats/file/base64.h"
#include "formats/file/scanner.h"

namespace tremolo {
namespace {

// Compressed numbers take more than two bits each in any mesh: a file that promises more of them
// is damaged, and would take memory without bound.
constexpr std::size_t kNumbersAByte = 4;

// One array: its element, its name and its position for errors.
struct VtuArray {
  const VtuDocument& document;
  pugi::xml_node node;
  std::string place;  // "FILE, array `types` (element at byte 800)"
};

// The bytes of an array in the file's encoding, which can be read up to any number.
struct VtuSource {
  std::string_view text;
  bool base64 = false;
};

Error not_base64(const VtuArray& array, std::string_view text, std::size_t bad_at) {
  return content_error(
      array.place + ": expected base64, found " +
      (bad_at >= text.size() ? "its end too early" : quoted_text(text.substr(bad_at))));
}

// At least the first `count` bytes. kept: where decoded bytes stay.
Result<std::string_view> first_bytes(const VtuArray& array, const VtuSource& source,
                                     std::size_t count, std::string& kept) {
  if (!source.base64) {
    if (count <= source.text.size()) return source.text.substr(0, count);
    return content_error(array.place + ": expected " + std::to_string(count) +
                         " bytes of appended data, found " + std::to_string(source.text.size()));
  }
  DecodedBase64 decoded = decode_base64(source.text, count);
  if (decoded.bad_at != std::string_view::npos)
    return not_base64(array, source.text, decoded.bad_at);
  kept = std::move(decoded.bytes);
  if (count <= kept.size()) return std::string_view(kept).substr(0, count);
  return content_error(array.place + ": expected " + std::to_string(count) + " bytes, found " +
                       std::to_string(kept.size()));
}

Result<VtuSource> find_source(const VtuArray& array, const std::string& format) {
  const VtuDocument& document = array.document;
  if (format == "binary") return VtuSource{array.node.text().get(), true};
  if (format != "appended")
    return content_error(array.place +
                         ": expected format \"ascii\", \"binary\" or \"appended\", found " +
                         quoted_text(format));
  const std::string offset_text = array.node.attribute("offset").value();
  TextScanner scanner(offset_text, array.place + ", attribute offset", {.open_end = true});
  std::size_t offset = 0;
  if (!scanner.read(offset, "a number of bytes")) return scanner.error();
  if (offset >= document.appended.size())
    return content_error(array.place + ": expected an offset in the " +
                         std::to_string(document.appended.size()) +
                         " bytes of the element AppendedData, found " + std::to_string(offset));
  return VtuSource{document.appended.substr(offset), document.appended_base64};
}

// The size that precedes uncompressed data.
Result<std::uint64_t> plain_size(const VtuArray& array, std::string_view header) {
  ByteScanner scanner(header, array.place, 0, array.document.swap);
  std::uint64_t size = 0;
  std::uint32_t short_size = 0;
  if (!(array.document.long_header ? scanner.read(size, "a size in bytes")
                                   : scanner.read(short_size, "a size in bytes")))
    return scanner.error();
  return array.document.long_header ? size : short_size;
}

// Uncompressed data. Inside an element they must be the last part.
Result<std::string> plain_bytes(const VtuArray& array, const VtuSource& source, bool is_inline) {
  std::string kept;
  const std::size_t header = array.document.long_header ? 8 : 4;
  if (is_inline) {
    DecodedBase64 decoded = decode_base64(source.text);
    if (decoded.bad_at != std::string_view::npos)
      return not_base64(array, source.text, decoded.bad_at);
    const Result<std::uint64_t> size = plain_size(array, decoded.bytes);
    if (!size) return size.error();
    const std::size_t found = decoded.bytes.size() - header;
    if (*size == found) return decoded.bytes.substr(header);
    return content_error(array.place + ": expected " + std::to_string(*size) +
                         " bytes behind the size, found " + std::to_string(found));
  }
  const Result<std::string_view> first = first_bytes(array, source, header, kept);
  if (!first) return first.error();
  const Result<std::uint64_t> size = plain_size(array, *first);
  if (!size) return size.error();
  if (*size > source.text.size())
    return content_error(array.place + ": expected " + std::to_string(*size) +
                         " bytes of appended data, found " + std::to_string(source.text.size()));
  const Result<std::string_view> all = first_bytes(array, source, header + *size, kept);
  if (!all) return all.error();
  return std::string(all->substr(header));
}

// Number of blocks, bytes of a block, bytes of the last if it is shorter, compressed bytes of each.
Result<std::string> compressed_bytes(const VtuArray& array, const VtuSource& source) {
  const std::size_t width = array.document.long_header ? 8 : 4;
  std::string kept;
  const auto header = [&](std::size_t count, std::vector<std::uint64_t>& values) -> Status {
    const Result<std::string_view> bytes = first_bytes(array, source, count * width, kept);
    if (!bytes) return bytes.error();
    ByteScanner scanner(*bytes, array.place, 0, array.document.swap);
    values.assign(count, 0);
    for (std::uint64_t& value : values) {
      std::uint32_t narrow = 0;
      if (!(width == 8 ? scanner.read(value, "a size") : scanner.read(narrow, "a size")))
        return scanner.error();
      if (width == 4) value = narrow;
    }
    return Success{};
  };
  std::vector<std::uint64_t> sizes;
  Status status = header(1, sizes);
  if (!status) return status.error();
  const std::size_t limit = source.text.size();
  const std::uint64_t count = sizes[0];
  if (count == 0) return std::string();
  if (count > limit / width)
    return content_error(array.place + ": expected at most " + std::to_string(limit / width) +
                         " compressed blocks, found " + std::to_string(count));
  status = header(3 + count, sizes);
  if (!status) return status.error();
  VtuBlocks blocks{sizes[1], sizes[2], {sizes.begin() + 3, sizes.end()}};
  std::uint64_t taken = 0;
  for (const std::uint64_t size : blocks.compressed) {
    if (size > limit - taken)
      return content_error(array.place + ": expected compressed blocks of at most " +
                           std::to_string(limit) + " bytes, found more");
    taken += size;
  }
  const std::size_t most = 8 * array.document.most_numbers;
  if (blocks.block > most / count || blocks.last > most)
    return content_error(array.place + ": expected at most " + std::to_string(most) +
                         " bytes of numbers in a file of this size, found " +
                         std::to_string(count) + " blocks of " + std::to_string(sizes[1]));
  const std::size_t before = (3 + count) * width;
  const Result<std::string_view> all = first_bytes(array, source, before + taken, kept);
  if (!all) return all.error();
  return decompress_blocks(array.document.compression, blocks, all->substr(before), array.place);
}

template <class Stored, class T>
Status read_stored(ByteScanner scanner, std::size_t count, std::vector<T>& values) {
  if (!scanner.fits(count, sizeof(Stored), "numbers")) return scanner.error();
  values.reserve(count);
  for (std::size_t n = 0; n < count; ++n) {
    Stored stored{};
    if (!scanner.read(stored, "a number")) return scanner.error();
    values.push_back(static_cast<T>(stored));
  }
  if (scanner.remaining() == 0) return Success{};
  return scanner.problem("expected " + std::to_string(count) + " numbers, found " +
                         std::to_string(scanner.remaining()) + " bytes more");
}

template <class T>
Status read_bytes(const VtuArray& array, const std::string& format, std::size_t count,
                  std::vector<T>& values) {
  const Result<VtuSource> source = find_source(array, format);
  if (!source) return source.error();
  const Result<std::string> bytes = array.document.compression == VtuCompression::kNone
                                        ? plain_bytes(array, *source, format == "binary")
                                        : compressed_bytes(array, *source);
  if (!bytes) return bytes.error();
  ByteScanner scanner(*bytes, array.place, 0, array.document.swap);
  const std::string type = array.node.attribute("type").value();
  if (type == "Float32") return read_stored<float>(scanner, count, values);
  if (type == "Float64") return read_stored<double>(scanner, count, values);
  if (type == "Int8") return read_stored<std::int8_t>(scanner, count, values);
  if (type == "UInt8") return read_stored<std::uint8_t>(scanner, count, values);
  if (type == "Int16") return read_stored<std::int16_t>(scanner, count, values);
  if (type == "UInt16") return read_stored<std::uint16_t>(scanner, count, values);
  if (type == "Int32") return read_stored<std::int32_t>(scanner, count, values);
  if (type == "UInt32") return read_stored<std::uint32_t>(scanner, count, values);
  if (type == "Int64") return read_stored<std::int64_t>(scanner, count, values);
  if (type == "UInt64") return read_stored<std::uint64_t>(scanner, count, values);
  return content_error(array.place + ": expected a type of numbers, found " + quoted_text(type));
}

template <class T>
Status read_text(const VtuArray& array, std::size_t count, std::vector<T>& values) {
  TextScanner scanner(array.node.text().get(), array.place, {.open_end = true});
  if (!scanner.fits(count, 2, "numbers")) return scanner.error();
  values.resize(count);
  for (T& value : values)
    if (!scanner.read(value, "a number")) return scanner.error();
  if (scanner.at_end()) return Success{};
  return scanner.problem("expected " + std::to_string(count) + " numbers, found more");
}

template <class T>
Status read_array(const VtuDocument& document, pugi::xml_node node, const std::string& shown,
                  std::size_t count, std::vector<T>& values) {
  const VtuArray array{document, node,
                       document.path + ", array " + shown + " (element at byte " +
                           std::to_string(node.offset_debug()) + ")"};
  if (count > document.most_numbers)
    return content_error(array.place + ": expected at most " +
                         std::to_string(document.most_numbers) +
                         " numbers in a file of this size, found " + std::to_string(count));
  values.clear();
  const std::string type = node.attribute("type").value();
  if (std::is_integral_v<T> && type.starts_with("Float"))
    return content_error(array.place + ": expected integers, found type " + quoted_text(type));
  const std::string format = node.attribute("format").as_string("ascii");
  return format == "ascii" ? read_text(array, count, values)
                           : read_bytes(array, format, count, values);
}

Status read_root(VtuDocument& document) {
  const pugi::xml_node root = document.root();
  const std::string& path = document.path;
  const std::string type = root.attribute("type").value();
  document.partitioned = type == "PUnstructuredGrid";
  if (type != "UnstructuredGrid" && !document.partitioned)
    return content_error(path + ": expected a VTKFile of type UnstructuredGrid, found " +
                         quoted_text(type));
  const std::string compressor = root.attribute("compressor").value();
  if (compressor == "vtkZLibDataCompressor")
    document.compression = VtuCompression::kZlib;
  else if (compressor == "vtkLZ4DataCompressor")
    document.compression = VtuCompression::kLz4;
  else if (!compressor.empty())
    return content_error(path + ": expected data compressed by zlib or LZ4, found " +
                         quoted_text(compressor) +
                         "; save the mesh with one of those, or not compressed");
  const std::string order = root.attribute("byte_order").as_string("LittleEndian");
  const std::string header = root.attribute("header_type").as_string("UInt32");
  if (order != "LittleEndian" && order != "BigEndian")
    return content_error(path + ": expected byte_order LittleEndian or BigEndian, found " +
                         quoted_text(order));
  if (header != "UInt32" && header != "UInt64")
    return content_error(path + ": expected header_type UInt32 or UInt64, found " +
                         quoted_text(header));
  document.swap = (order == "LittleEndian") == kSwapsLittleEndian;
  document.long_header = header == "UInt64";
  return Success{};
}

// Finds the data of the element AppendedData, whose tag is at `begin`. They are not XML if they are
// raw.
Status cut_appended(std::string_view text, std::size_t begin, VtuDocument& document) {
  const std::size_t end = text.find('>', begin);
  if (end == std::string_view::npos)
    return content_error(document.path + ", byte " + std::to_string(begin) +
                         ": expected the end of the tag AppendedData, found the end of the file");
  const std::string_view tag = text.substr(begin, end - begin);
  const bool raw = tag.find("raw") != std::string_view::npos;
  if (!raw && tag.find("base64") == std::string_view::npos)
    return content_error(document.path + ", byte " + std::to_string(begin) +
                         ": expected encoding=\"raw\" or encoding=\"base64\" of AppendedData, "
                         "found " +
                         quoted_text(tag));
  std::size_t first = end + 1;
  while (first < text.size() &&
         (text[first] == ' ' || text[first] == '\n' || text[first] == '\r' || text[first] == '\t'))
    ++first;
  if (first == text.size() || text[first] != '_')
    return content_error(document.path + ", byte " + std::to_string(first) +
                         ": expected an underscore, with which appended data begin");
  document.appended = text.substr(first + 1);
  document.appended_base64 = !raw;
  // Base64 has no `<`; raw bytes may have more bytes after them, which are ignored.
  if (!raw) document.appended = document.appended.substr(0, document.appended.find('<'));
  return Success{};
}

}  // namespace

Status open_vtu(std::string_view text, const std::string& path, VtuDocument& document) {
  document.path = path;
  document.most_numbers = text.size();
  const std::size_t begin = text.find("<AppendedData");
  pugi::xml_parse_result parsed;
  if (begin == std::string_view::npos) {
    parsed = document.xml.load_buffer(text.data(), text.size());
  } else {
    const Status status = cut_appended(text, begin, document);
    if (!status) return status;
    const std::string before = std::string(text.substr(0, begin)) + "</VTKFile>";
    parsed = document.xml.load_buffer(before.data(), before.size());
  }
  if (!parsed)
    return content_error(path + ", byte " + std::to_string(parsed.offset) +
                         ": expected well-formed XML, found: " + parsed.description());
  const Status status = read_root(document);
  if (status && document.compression != VtuCompression::kNone)
    document.most_numbers = kNumbersAByte * text.size();
  return status;
}

Status read_vtu_array(const VtuDocument& document, pugi::xml_node node, const std::string& shown,
                      std::size_t count, std::vector<std::int64_t>& values) {
  return read_array(document, node, shown, count, values);
}

Status read_vtu_array(const VtuDocument& document, pugi::xml_node node, const std::string& shown,
                      std::size_t count, std::vector<double>& values) {
  return read_array(document, node, shown, count, values);
}

}  // namespace tremolo
