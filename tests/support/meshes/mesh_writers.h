// A mesh of any size in every format that is read, all digits of its coordinates kept.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tests/support/meshes/small_mesh.h"

namespace tremolo::testing {

// {name, bytes}; the first is the one to read.
using NamedFiles = std::vector<std::pair<std::string, std::string>>;

inline std::string vertex_lines(const TetMesh& mesh, int base, bool with_ids) {
  std::string text;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    text += (with_ids ? std::to_string(v + base) + " " : "") + join(mesh.vertices[v]) + "\n";
  return text;
}

// before: the text between an element's id and its nodes.
inline std::string element_lines(const TetMesh& mesh, int base, const std::string& before) {
  std::string text;
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e)
    text += std::to_string(e + base) + before + join(mesh.tetrahedra[e], base) + "\n";
  return text;
}

inline NamedFiles as_msh2(const TetMesh& mesh) {
  return {{"a.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" +
                        std::to_string(mesh.vertices.size()) + "\n" + vertex_lines(mesh, 1, true) +
                        "$EndNodes\n$Elements\n" + std::to_string(mesh.tetrahedra.size()) + "\n" +
                        element_lines(mesh, 1, " 4 2 0 1") + "$EndElements\n"}};
}

inline NamedFiles as_msh4(const TetMesh& mesh) {
  const std::string n = std::to_string(mesh.vertices.size());
  const std::string m = std::to_string(mesh.tetrahedra.size());
  std::string ids;
  for (std::size_t v = 1; v <= mesh.vertices.size(); ++v) ids += std::to_string(v) + "\n";
  return {{"a.msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 " + n + " 1 " + n +
                        "\n3 1 0 " + n + "\n" + ids + vertex_lines(mesh, 1, false) +
                        "$EndNodes\n$Elements\n1 " + m + " 1 " + m + "\n3 1 4 " + m + "\n" +
                        element_lines(mesh, 1, "") + "$EndElements\n"}};
}

inline NamedFiles as_vtk(const TetMesh& mesh) {
  const std::string m = std::to_string(mesh.tetrahedra.size());
  std::string text = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS " +
                     std::to_string(mesh.vertices.size()) + " double\n" +
                     vertex_lines(mesh, 0, false) + "CELLS " + m + " " +
                     std::to_string(5 * mesh.tetrahedra.size()) + "\n";
  for (const Tetrahedron& tet : mesh.tetrahedra) text += "4" + join(tet, 0) + "\n";
  text += "CELL_TYPES " + m + "\n";
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) text += "10\n";
  return {{"a.vtk", text}};
}

inline NamedFiles as_vtu(const TetMesh& mesh) {
  std::string nodes, offsets, types;
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) {
    nodes += join(mesh.tetrahedra[e], 0) + "\n";
    offsets += std::to_string(4 * (e + 1)) + "\n";
    types += "10\n";
  }
  const auto array = [](const std::string& attributes, const std::string& values) {
    return "<DataArray " + attributes + " format=\"ascii\">\n" + values + "</DataArray>\n";
  };
  return {{"a.vtu",
           "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\">\n"
           "<UnstructuredGrid><Piece NumberOfPoints=\"" +
               std::to_string(mesh.vertices.size()) + "\" NumberOfCells=\"" +
               std::to_string(mesh.tetrahedra.size()) + "\">\n<Points>" +
               array("type=\"Float64\" NumberOfComponents=\"3\"", vertex_lines(mesh, 0, false)) +
               "</Points><Cells>" + array("type=\"Int64\" Name=\"connectivity\"", nodes) +
               array("type=\"Int64\" Name=\"offsets\"", offsets) +
               array("type=\"UInt8\" Name=\"types\"", types) +
               "</Cells></Piece></UnstructuredGrid></VTKFile>\n"}};
}

inline NamedFiles as_veg(const TetMesh& mesh) {
  return {{"a.veg", "*VERTICES\n" + std::to_string(mesh.vertices.size()) + " 3 0 0\n" +
                        vertex_lines(mesh, 1, true) + "*ELEMENTS\nTETS\n" +
                        std::to_string(mesh.tetrahedra.size()) + " 4 0\n" +
                        element_lines(mesh, 1, "")}};
}

inline NamedFiles as_tetgen(const TetMesh& mesh) {
  return {
      {"a.node", std::to_string(mesh.vertices.size()) + " 3 0 0\n" + vertex_lines(mesh, 0, true)},
      {"a.ele", std::to_string(mesh.tetrahedra.size()) + " 4 0\n" + element_lines(mesh, 0, "")}};
}

}  // namespace tremolo::testing
