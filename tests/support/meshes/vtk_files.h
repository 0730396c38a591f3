// small_mesh() as VTK files, legacy and XML, with the triangle.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "tests/support/meshes/small_mesh.h"

namespace tremolo::testing {

inline std::string vtk_text() {
  const TetMesh mesh = small_mesh();
  std::string text = "# vtk DataFile Version 3.0\nany title\nASCII\nDATASET UNSTRUCTURED_GRID\n";
  text += "FIELD FieldData 1\nTIME 1 2 double\n0.5 0.25\nPOINTS 5 double\n";
  for (const Eigen::Vector3d& x : mesh.vertices) text += join(x) + "\n";
  text += "METADATA\nINFORMATION 0\n\nCELLS 3 14\n3" + join(kTriangle, 0) + "\n";
  for (const Tetrahedron& tet : mesh.tetrahedra) text += "4" + join(tet, 0) + "\n";
  return text + "CELL_TYPES 3\n5\n10\n10\nPOINT_DATA 5\nSCALARS a float 1\nnot read\n";
}

inline std::string vtk_text_5_1() {
  const TetMesh mesh = small_mesh();
  std::string text = "# vtk DataFile Version 5.1\nany title\nASCII\nDATASET UNSTRUCTURED_GRID\n";
  text += "POINTS 5 float\n";
  for (const Eigen::Vector3d& x : mesh.vertices) text += join(x) + " ";
  text += "\nCELLS 4 11\nOFFSETS vtktypeint64\n0 3 7 11\nCONNECTIVITY vtktypeint64\n";
  text += join(kTriangle, 0);
  for (const Tetrahedron& tet : mesh.tetrahedra) text += join(tet, 0);
  return text + "\n\nCELL_TYPES 3\n5\n10\n10\n";
}

inline std::string vtk_binary() {
  const TetMesh mesh = small_mesh();
  ByteWriter bytes(true);
  bytes.text("# vtk DataFile Version 3.0\nany title\nBINARY\nDATASET UNSTRUCTURED_GRID\n");
  bytes.text("FIELD FieldData 1\nTIME 1 1 int\n").put(std::int32_t{7}).text("\nPOINTS 5 float\n");
  for (const Eigen::Vector3d& x : mesh.vertices)
    for (double c : x) bytes.put(static_cast<float>(c));
  bytes.text("\nCELLS 3 14\n").put(std::int32_t{3});
  for (VertexId v : kTriangle) bytes.put(v);
  for (const Tetrahedron& tet : mesh.tetrahedra) {
    bytes.put(std::int32_t{4});
    for (VertexId v : tet) bytes.put(v);
  }
  bytes.text("\nCELL_TYPES 3\n");
  for (int type : {5, 10, 10}) bytes.put(static_cast<std::int32_t>(type));
  return bytes.text("\nCELL_DATA 3\nnot read").str();
}

inline std::string vtk_binary_5_1() {
  const TetMesh mesh = small_mesh();
  ByteWriter bytes(true);
  bytes.text("# vtk DataFile Version 5.1\nany title\nBINARY\nDATASET UNSTRUCTURED_GRID\n");
  bytes.text("POINTS 5 double\n");
  for (const Eigen::Vector3d& x : mesh.vertices) bytes.put(x);
  bytes.text("\nCELLS 4 11\nOFFSETS vtktypeint64\n");
  for (int offset : {0, 3, 7, 11}) bytes.put(static_cast<std::int64_t>(offset));
  bytes.text("\nCONNECTIVITY vtktypeint64\n");
  for (VertexId v : kTriangle) bytes.put(static_cast<std::int64_t>(v));
  for (const Tetrahedron& tet : mesh.tetrahedra)
    for (VertexId v : tet) bytes.put(static_cast<std::int64_t>(v));
  bytes.text("\nCELL_TYPES 3\n");
  for (int type : {5, 10, 10}) bytes.put(static_cast<std::int32_t>(type));
  return bytes.text("\n").str();
}

inline std::string vtu_file(const std::string& root, const std::string& format,
                            const std::array<std::string, 4>& data) {
  const std::string array = "<DataArray format=\"" + format + "\" type=";
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" " + root +
         ">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"5\" NumberOfCells=\"3\">\n<Points>\n" +
         array + "\"Float64\" NumberOfComponents=\"3\" Name=\"Points\">\n" + data[0] +
         "\n</DataArray>\n</Points>\n<Cells>\n" + array + "\"Int32\" Name=\"connectivity\">\n" +
         data[1] + "\n</DataArray>\n" + array + "\"Int64\" Name=\"offsets\">\n" + data[2] +
         "\n</DataArray>\n" + array + "\"UInt8\" Name=\"types\">\n" + data[3] +
         "\n</DataArray>\n</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

inline std::string vtu_text() {
  const TetMesh mesh = small_mesh();
  std::string points;
  std::string nodes = join(kTriangle, 0);
  for (const Eigen::Vector3d& x : mesh.vertices) points += join(x) + "\n";
  for (const Tetrahedron& tet : mesh.tetrahedra) nodes += join(tet, 0);
  return vtu_file("byte_order=\"LittleEndian\"", "ascii", {points, nodes, "3 7 11", "5 10 10"});
}

inline std::string vtu_base64(bool big_endian, bool long_header) {
  const TetMesh mesh = small_mesh();
  const auto encoded = [&](const ByteWriter& data) {
    ByteWriter whole(big_endian);
    if (long_header)
      whole.put(static_cast<std::uint64_t>(data.str().size()));
    else
      whole.put(static_cast<std::uint32_t>(data.str().size()));
    return base64(whole.text(data.str()).str());
  };
  ByteWriter points(big_endian);
  ByteWriter nodes(big_endian);
  ByteWriter offsets(big_endian);
  ByteWriter types(big_endian);
  for (const Eigen::Vector3d& x : mesh.vertices) points.put(x);
  for (VertexId v : kTriangle) nodes.put(v);
  for (const Tetrahedron& tet : mesh.tetrahedra)
    for (VertexId v : tet) nodes.put(v);
  for (int offset : {3, 7, 11}) offsets.put(static_cast<std::int64_t>(offset));
  for (int type : {5, 10, 10}) types.put(static_cast<std::uint8_t>(type));
  return vtu_file(std::string("byte_order=\"") + (big_endian ? "Big" : "Little") +
                      "Endian\" header_type=\"" + (long_header ? "UInt64" : "UInt32") + "\"",
                  "binary", {encoded(points), encoded(nodes), encoded(offsets), encoded(types)});
}

}  // namespace tremolo::testing
