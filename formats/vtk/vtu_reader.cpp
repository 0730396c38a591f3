#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <pugixml.hpp>
#include <string>
#include <type_traits>
#include <vector>

#include "formats/file/base64.h"
#include "formats/file/byte_scanner.h"
#include "formats/file/text_scanner.h"
#include "formats/mesh/mesh_formats.h"
#include "formats/vtk/vtk_cells.h"

namespace tremolo {
namespace {

// What the root element says about the bytes of all arrays.
struct VtuBytes {
  bool swap = false;
  bool long_header = false;  // sizes before the data are u64 rather than u32
};

struct VtuArray {
  pugi::xml_node node;
  std::string place;  // "FILE, array `types` (byte 800)"
  VtuBytes bytes;
};

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

// Base64 of the size in bytes and the data.
template <class T>
Status read_base64(const VtuArray& array, std::size_t count, std::vector<T>& values) {
  const std::string_view text = array.node.text().get();
  const DecodedBase64 decoded = decode_base64(text);
  if (decoded.bad_at != std::string_view::npos)
    return content_error(array.place + ": expected base64, found " +
                         (decoded.bad_at == text.size()
                              ? "its end too early"
                              : quoted_text(text.substr(decoded.bad_at))));
  ByteScanner scanner(decoded.bytes, array.place, 0, array.bytes.swap);
  std::uint64_t size = 0;
  std::uint32_t short_size = 0;
  if (!(array.bytes.long_header ? scanner.read(size, "a size in bytes")
                                : scanner.read(short_size, "a size in bytes")))
    return scanner.error();
  if (!array.bytes.long_header) size = short_size;
  if (size != scanner.remaining())
    return scanner.problem("expected " + std::to_string(size) + " bytes behind the size, found " +
                           std::to_string(scanner.remaining()));
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
Status read_array(const VtuArray& array, std::size_t count, std::vector<T>& values) {
  const std::string type = array.node.attribute("type").value();
  if (std::is_integral_v<T> && type.starts_with("Float"))
    return content_error(array.place + ": expected integers, found type " + quoted_text(type));
  const std::string encoding = array.node.attribute("format").value();
  if (encoding == "ascii") return read_text(array, count, values);
  if (encoding == "binary") return read_base64(array, count, values);
  return content_error(array.place + ": expected format \"ascii\" or \"binary\", found " +
                       quoted_text(encoding) + "; save the mesh with inline data");
}

Result<VtuArray> find_array(pugi::xml_node parent, const char* name, const VtuBytes& bytes,
                            const std::string& path) {
  const pugi::xml_node node = *name != '\0'
                                  ? parent.find_child_by_attribute("DataArray", "Name", name)
                                  : parent.child("DataArray");
  const std::string shown = *name != '\0' ? name : "points";
  if (!node) return content_error(path + ": expected a DataArray of " + shown + ", found none");
  return VtuArray{node,
                  path + ", array `" + shown + "` (element at byte " +
                      std::to_string(node.offset_debug()) + ")",
                  bytes};
}

template <class T>
Status read_named(pugi::xml_node parent, const char* name, const VtuBytes& bytes,
                  const std::string& path, std::size_t count, std::vector<T>& values) {
  const Result<VtuArray> array = find_array(parent, name, bytes, path);
  if (!array) return array.error();
  return read_array(*array, count, values);
}

Result<VtuBytes> read_root(pugi::xml_node root, const std::string& path) {
  const std::string type = root.attribute("type").value();
  if (type != "UnstructuredGrid")
    return content_error(path + ": expected a VTKFile of type UnstructuredGrid, found " +
                         quoted_text(type));
  if (root.attribute("compressor"))
    return content_error(path + ": expected data that are not compressed, found " +
                         quoted_text(root.attribute("compressor").value()));
  const std::string order = root.attribute("byte_order").as_string("LittleEndian");
  const std::string header = root.attribute("header_type").as_string("UInt32");
  if (order != "LittleEndian" && order != "BigEndian")
    return content_error(path + ": expected byte_order LittleEndian or BigEndian, found " +
                         quoted_text(order));
  if (header != "UInt32" && header != "UInt64")
    return content_error(path + ": expected header_type UInt32 or UInt64, found " +
                         quoted_text(header));
  const bool little = std::endian::native == std::endian::little;
  return VtuBytes{(order == "LittleEndian") != little, header == "UInt64"};
}

// Counts of a piece, bounded by the size of the file, in which each item takes at least a byte.
Result<std::size_t> read_count(pugi::xml_node piece, const char* name, std::size_t limit,
                               const std::string& path) {
  const std::string value = piece.attribute(name).value();
  TextScanner scanner(value, path + ", attribute " + name, {.open_end = true});
  std::size_t count = 0;
  if (!scanner.read(count, "a count")) return scanner.error();
  if (count > limit)
    return scanner.problem("expected a count that fits in a file of " + std::to_string(limit) +
                           " bytes, found " + value);
  return count;
}

Status read_points(pugi::xml_node piece, const VtuBytes& bytes, const std::string& path,
                   std::size_t count, MeshBuilder& builder) {
  std::vector<double> coordinates;
  Status status = read_named(piece.child("Points"), "", bytes, path, 3 * count, coordinates);
  if (!status) return status;
  builder.reserve_vertices(count);
  for (std::size_t p = 0; p < count; ++p)
    if (!builder.add_vertex(p, Eigen::Vector3d(coordinates.data() + 3 * p)))
      return content_error(path + ", array `points`: " + builder.complaint());
  if (!builder.seal_vertices()) return content_error(path + ": " + builder.complaint());
  return Success{};
}

// The cell array that numbers regions, if there is one. What is wrong with it is noted: the mesh
// does not need it.
void read_regions(pugi::xml_node piece, const VtuBytes& bytes, const std::string& path,
                  const VtkCells& cells, MeshBuilder& builder) {
  int best = std::numeric_limits<int>::max();
  pugi::xml_node chosen;
  for (const pugi::xml_node array : piece.child("CellData").children("DataArray")) {
    const int rank = region_rank(array.attribute("Name").value());
    if (rank < 0 || rank >= best || array.attribute("NumberOfComponents").as_int(1) > 1) continue;
    best = rank;
    chosen = array;
  }
  if (!chosen) return;
  const std::string name = chosen.attribute("Name").value();
  const VtuArray array{chosen,
                       path + ", array " + quoted_text(name) + " (element at byte " +
                           std::to_string(chosen.offset_debug()) + ")",
                       bytes};
  std::vector<double> values;
  const Status status = read_array(array, cells.types.size(), values);
  if (status)
    set_vtk_regions(cells, name, values, builder);
  else
    builder.add_note("the regions are not read: " + status.error().message);
}

Status read_cells(pugi::xml_node piece, const VtuBytes& bytes, const std::string& path,
                  std::size_t count, std::size_t limit, MeshBuilder& builder) {
  const pugi::xml_node cells = piece.child("Cells");
  VtkCells found;
  Status status = read_named(cells, "offsets", bytes, path, count, found.offsets);
  if (status) status = read_named(cells, "types", bytes, path, count, found.types);
  if (!status) return status;
  // VTU leaves out the first offset, 0; the last is the length of the list of nodes.
  found.offsets.insert(found.offsets.begin(), 0);
  const std::int64_t length = found.offsets.back();
  if (length < 0 || std::cmp_greater(length, limit))
    return content_error(path +
                         ", array `offsets`: expected a last offset that fits in a file of " +
                         std::to_string(limit) + " bytes, found " + std::to_string(length));
  status = read_named(cells, "connectivity", bytes, path, length, found.connectivity);
  if (!status) return status;
  const std::string complaint = add_vtk_cells(found, builder);
  if (!complaint.empty()) return content_error(path + ": " + complaint);
  read_regions(piece, bytes, path, found, builder);
  return Success{};
}

}  // namespace

Result<MeshFile> read_vtu(std::string_view text, const std::string& path) {
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer(text.data(), text.size());
  if (!parsed)
    return content_error(path + ", byte " + std::to_string(parsed.offset) +
                         ": expected well-formed XML, found: " + parsed.description());
  const pugi::xml_node root = document.child("VTKFile");
  const Result<VtuBytes> bytes = read_root(root, path);
  if (!bytes) return bytes.error();
  const pugi::xml_node piece = root.child("UnstructuredGrid").child("Piece");
  if (!piece || piece.next_sibling("Piece"))
    return content_error(path + ": expected one Piece, found " + (piece ? "several" : "none"));
  const Result<std::size_t> points = read_count(piece, "NumberOfPoints", text.size(), path);
  if (!points) return points.error();
  const Result<std::size_t> cells = read_count(piece, "NumberOfCells", text.size(), path);
  if (!cells) return cells.error();
  MeshBuilder builder(path);
  Status status = read_points(piece, *bytes, path, *points, builder);
  if (status) status = read_cells(piece, *bytes, path, *cells, text.size(), builder);
  if (!status) return status.error();
  return builder.finish("VTU");
}

}  // namespace tremolo
