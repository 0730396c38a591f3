// VTK files, legacy and XML, as VTK and ParaView, meshio, SOFA and Gmsh write them.
#pragma once

#include <lz4.h>
#include <zlib.h>

#include "tests/support/meshes/forms/form_mesh.h"

namespace tremolo::testing {

struct VtuForm {
  enum class Compression { kNone, kZlib, kLz4 };
  Compression compression = Compression::kNone;
  enum class Place { kText, kInline, kAppendedRaw, kAppendedBase64 };
  Place place = Place::kInline;
  bool long_header = false;
  int pieces = 1;
  bool regions = true;
};

// The arrays of one VTU file, whose appended bytes collect behind each other.
class VtuFormWriter {
 public:
  explicit VtuFormWriter(const VtuForm& form) : form_(form) {}

  template <class T>
  std::string array(const std::string& type, const std::string& name, int components,
                    const std::vector<T>& values) {
    std::string head = "<DataArray type=\"" + type + "\" Name=\"" + name + "\"";
    if (components > 1) head += " NumberOfComponents=\"" + std::to_string(components) + "\"";
    if (form_.place == VtuForm::Place::kText) {
      std::string text;
      for (const T value : values) text += number(static_cast<double>(value)) + " ";
      return head + " format=\"ascii\">\n" + text + "\n</DataArray>\n";
    }
    std::string bytes(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    if (form_.place == VtuForm::Place::kInline)
      return head + " format=\"binary\">\n" + stored(bytes, true) + "\n</DataArray>\n";
    const std::string at = std::to_string(appended_.size());
    appended_ += stored(bytes, form_.place == VtuForm::Place::kAppendedBase64);
    return head + " format=\"appended\" offset=\"" + at + "\"/>\n";
  }
  const std::string& appended() const { return appended_; }

 private:
  std::string sizes(const std::vector<std::size_t>& values) const {
    ByteWriter header(false);
    for (const std::size_t value : values)
      if (form_.long_header)
        header.put(static_cast<std::uint64_t>(value));
      else
        header.put(static_cast<std::uint32_t>(value));
    return header.str();
  }
  std::string compressed(const std::string& block) const {
    if (form_.compression == VtuForm::Compression::kZlib) {
      uLongf size = compressBound(block.size());
      std::string out(size, '\0');
      compress(reinterpret_cast<Bytef*>(out.data()), &size,
               reinterpret_cast<const Bytef*>(block.data()), block.size());
      return out.substr(0, size);
    }
    std::string out(LZ4_compressBound(static_cast<int>(block.size())), '\0');
    const int size = LZ4_compress_default(block.data(), out.data(), static_cast<int>(block.size()),
                                          static_cast<int>(out.size()));
    return out.substr(0, size);
  }
  // Blocks of 512 bytes, so that an array has several and a last one that is shorter.
  std::string stored(const std::string& bytes, bool in_base64) const {
    if (form_.compression == VtuForm::Compression::kNone) {
      const std::string whole = sizes({bytes.size()}) + bytes;
      return in_base64 ? base64(whole) : whole;
    }
    constexpr std::size_t kBlock = 512;
    std::vector<std::size_t> header = {0, kBlock, bytes.size() % kBlock};
    std::string blocks;
    for (std::size_t at = 0; at < bytes.size(); at += kBlock) {
      const std::string block = compressed(bytes.substr(at, kBlock));
      header.push_back(block.size());
      blocks += block;
      ++header[0];
    }
    return in_base64 ? base64(sizes(header)) + base64(blocks) : sizes(header) + blocks;
  }

  VtuForm form_;
  std::string appended_;
};

// One piece of the whole, or one for each half, with points of its own.
inline std::string form_vtu(const VtuForm& form) {
  const FormBar bar;
  VtuFormWriter writer(form);
  std::string pieces;
  for (int piece = 0; piece < form.pieces; ++piece) {
    std::vector<double> points;
    std::vector<std::int64_t> nodes, offsets;
    std::vector<std::uint8_t> types;
    std::vector<std::int32_t> region;
    std::map<VertexId, std::int64_t> own;
    if (form.pieces == 1)
      for (std::size_t v = 0; v < bar.mesh.vertices.size(); ++v) {
        own[static_cast<VertexId>(v)] = static_cast<std::int64_t>(v);
        for (const double c : bar.mesh.vertices[v]) points.push_back(c);
      }
    for (std::size_t t = 0; t < bar.half.size(); ++t) {
      if (form.pieces > 1 && bar.half[t] != piece) continue;
      for (const VertexId v : bar.mesh.tetrahedra[t]) {
        const auto [entry, fresh] = own.try_emplace(v, static_cast<std::int64_t>(own.size()));
        if (fresh)
          for (const double c : bar.mesh.vertices[v]) points.push_back(c);
        nodes.push_back(entry->second);
      }
      offsets.push_back(static_cast<std::int64_t>(nodes.size()));
      types.push_back(10);
      region.push_back(1 + bar.half[t]);
    }
    pieces += "<Piece NumberOfPoints=\"" + std::to_string(points.size() / 3) +
              "\" NumberOfCells=\"" + std::to_string(types.size()) + "\">\n";
    if (form.regions)
      pieces += "<CellData>\n" + writer.array("Int32", "MaterialIds", 1, region) + "</CellData>\n";
    pieces += "<Points>\n" + writer.array("Float64", "Points", 3, points) + "</Points>\n<Cells>\n" +
              writer.array("Int64", "connectivity", 1, nodes) +
              writer.array("Int64", "offsets", 1, offsets) +
              writer.array("UInt8", "types", 1, types) + "</Cells>\n</Piece>\n";
  }
  std::string root =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
      "byte_order=\"LittleEndian\" header_type=\"";
  root += form.long_header ? "UInt64\"" : "UInt32\"";
  if (form.compression == VtuForm::Compression::kZlib)
    root += " compressor=\"vtkZLibDataCompressor\"";
  if (form.compression == VtuForm::Compression::kLz4)
    root += " compressor=\"vtkLZ4DataCompressor\"";
  const bool raw = form.place == VtuForm::Place::kAppendedRaw;
  const std::string appended = writer.appended().empty()
                                   ? ""
                                   : "<AppendedData encoding=\"" +
                                         std::string(raw ? "raw" : "base64") + "\">\n_" +
                                         writer.appended() + "\n</AppendedData>\n";
  return root + ">\n<UnstructuredGrid>\n" + pieces + "</UnstructuredGrid>\n" + appended +
         "</VTKFile>\n";
}

// before: what stands between DATASET and POINTS. triangles: as SOFA writes, before the tetrahedra.
inline std::string form_vtk_text(const std::string& version, const std::string& before,
                                 bool triangles, bool regions) {
  const FormBar bar;
  const std::size_t extra = triangles ? bar.foot_triangles.size() : 0;
  const std::size_t count = bar.mesh.tetrahedra.size() + extra;
  std::string text = "# vtk DataFile Version " + version +
                     "\nany title\nASCII\nDATASET UNSTRUCTURED_GRID\n" + before + "POINTS " +
                     std::to_string(bar.mesh.vertices.size()) + " double\n";
  for (const Eigen::Vector3d& x : bar.mesh.vertices) text += join(x) + "\n";
  const std::string n = std::to_string(count);
  std::string cells, types, offsets = "0", data;
  std::size_t at = 0;
  const bool late = version == "5.1";
  const auto add = [&](const auto& cell, int type, int region) {
    cells += (late ? "" : std::to_string(cell.size())) + join(cell, 0) + "\n";
    types += std::to_string(type) + "\n";
    offsets += " " + std::to_string(at += cell.size());
    data += std::to_string(region) + "\n";
  };
  for (std::size_t t = 0; t < extra; ++t) add(bar.foot_triangles[t], 5, 0);
  for (std::size_t t = 0; t < bar.half.size(); ++t)
    add(bar.mesh.tetrahedra[t], 10, 1 + bar.half[t]);
  if (late)
    text += "CELLS " + std::to_string(count + 1) + " " + std::to_string(at) +
            "\nOFFSETS vtktypeint64\n" + offsets + "\nCONNECTIVITY vtktypeint64\n" + cells;
  else
    text += "CELLS " + n + " " + std::to_string(at + count) + "\n" + cells;
  text += "\nCELL_TYPES " + n + "\n" + types;
  if (regions)
    text += "CELL_DATA " + n + "\nFIELD FieldData 2\nlabel 1 " + n + " string\n" +
            [&] {
              std::string labels;
              for (std::size_t c = 0; c < count; ++c)
                labels += "part%20" + std::to_string(c) + "\n";
              return labels;
            }() +
            "material 1 " + n + " int\n" + data + "METADATA\nINFORMATION 0\n\n";
  return text;
}

// With a string and bits in a FIELD before the points, as VTK 9 writes field data in binary.
inline std::string form_vtk_binary(bool late, bool strings) {
  const FormBar bar;
  const std::string n = std::to_string(bar.half.size());
  ByteWriter bytes(true);
  bytes.text(std::string("# vtk DataFile Version ") + (late ? "5.1" : "4.2") +
             "\nany title\nBINARY\nDATASET UNSTRUCTURED_GRID\n");
  if (strings) {
    const std::string word = "POINTS 9 double\n", sentence(100, 's');
    bytes.text("FIELD FieldData 2\nMeshName 1 2 string\n");
    bytes.put(static_cast<std::uint8_t>(0xc0 | word.size())).text(word);
    bytes.put(static_cast<std::uint16_t>(0x8000 | sentence.size())).text(sentence);
    bytes.text("\nMETADATA\nCOMPONENT_NAMES\nname\n\nflags 1 11 bit\n");
    bytes.put(std::uint8_t{0xa5}).put(std::uint8_t{0x20}).text("\n");
  }
  bytes.text("POINTS " + std::to_string(bar.mesh.vertices.size()) + " double\n");
  for (const Eigen::Vector3d& x : bar.mesh.vertices) bytes.put(x);
  if (late) {
    bytes.text("\nCELLS " + std::to_string(bar.half.size() + 1) + " " +
               std::to_string(4 * bar.half.size()) + "\nOFFSETS vtktypeint64\n");
    for (std::size_t t = 0; t <= bar.half.size(); ++t) bytes.put(static_cast<std::int64_t>(4 * t));
    bytes.text("\nCONNECTIVITY vtktypeint64\n");
    for (const Tetrahedron& tet : bar.mesh.tetrahedra)
      for (const VertexId v : tet) bytes.put(static_cast<std::int64_t>(v));
  } else {
    bytes.text("\nCELLS " + n + " " + std::to_string(5 * bar.half.size()) + "\n");
    for (const Tetrahedron& tet : bar.mesh.tetrahedra) {
      bytes.put(std::int32_t{4});
      for (const VertexId v : tet) bytes.put(v);
    }
  }
  bytes.text("\nCELL_TYPES " + n + "\n");
  for (std::size_t t = 0; t < bar.half.size(); ++t) bytes.put(std::int32_t{10});
  bytes.text("\nCELL_DATA " + n + "\nSCALARS region int 1\nLOOKUP_TABLE default\n");
  for (const int half : bar.half) bytes.put(static_cast<std::int32_t>(1 + half));
  return bytes.text("\n").str();
}

inline std::vector<WriterForm> vtk_forms() {
  using C = VtuForm::Compression;
  using P = VtuForm::Place;
  const std::vector<std::string> halves = {"region 1", "region 2"};
  std::vector<WriterForm> forms;
  const auto vtu = [&](const std::string& writer, const std::string& name, const VtuForm& form) {
    forms.push_back({writer, name, {{"a.vtu", form_vtu(form)}}, "", halves});
  };
  vtu("meshio", "VTU, zlib", {C::kZlib, P::kInline, false});
  vtu("meshio", "VTU, base64", {C::kNone, P::kInline, false});
  vtu("meshio", "VTU, text", {C::kNone, P::kText, false});
  vtu("ParaView", "VTU, appended raw", {C::kNone, P::kAppendedRaw, true});
  vtu("ParaView", "VTU, appended base64", {C::kNone, P::kAppendedBase64, true});
  vtu("ParaView", "VTU, zlib appended raw", {C::kZlib, P::kAppendedRaw, true});
  vtu("ParaView", "VTU, zlib appended base64", {C::kZlib, P::kAppendedBase64, false});
  vtu("ParaView", "VTU, LZ4 appended raw", {C::kLz4, P::kAppendedRaw, true});
  vtu("ParaView", "VTU, LZ4 appended base64", {C::kLz4, P::kAppendedBase64, false});
  vtu("ParaView", "VTU, LZ4", {C::kLz4, P::kInline, true});
  vtu("ParaView", "VTU, two pieces", {C::kZlib, P::kAppendedRaw, true, 2});
  vtu("ParaView", "VTU, two pieces, text", {C::kNone, P::kText, false, 2});
  const auto vtk = [&](const std::string& writer, const std::string& name, const std::string& bytes,
                       bool regions) {
    forms.push_back(
        {writer, name, {{"a.vtk", bytes}}, "", regions ? halves : std::vector<std::string>()});
  };
  const std::string field =
      "FIELD FieldData 3\nMeshName 1 2 string\nPart%20one\nPOINTS%203\nTIME 1 1 double\n0.5\n"
      "flags 1 3 bit\n1 0 1\nMETADATA\nCOMPONENT_NAMES\nname\n\n";
  vtk("ParaView", "VTK 5.1 binary, strings", form_vtk_binary(true, true), true);
  vtk("ParaView", "VTK 4.2 binary, strings", form_vtk_binary(false, true), true);
  vtk("ParaView", "VTK 5.1 text, strings", form_vtk_text("5.1", field, false, true), true);
  vtk("ParaView", "VTK 3.0 text, strings", form_vtk_text("3.0", field, true, true), true);
  vtk("meshio", "VTK 5.1 binary", form_vtk_binary(true, false), true);
  vtk("meshio", "VTK 4.2 binary", form_vtk_binary(false, false), true);
  vtk("gmsh", "VTK 2.0 text", form_vtk_text("2.0", "", false, false), false);
  vtk("pygmsh", "VTK 5.1 text", form_vtk_text("5.1", "", true, false), false);
  vtk("SOFA", "VTK 2.0 text", form_vtk_text("2.0", "", true, false), false);
  return forms;
}

}  // namespace tremolo::testing
