// One small mesh in every format that can be read.
#pragma once

#include <map>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/meshes/msh_files.h"
#include "tests/support/meshes/vega_files.h"
#include "tests/support/meshes/vtk_files.h"
#include "tests/support/row_files.h"

namespace tremolo::testing {

// files: {name, bytes}; the first is the one to read. sets: the expected node sets.
struct MeshVariant {
  std::string name;
  std::vector<std::pair<std::string, std::string>> files;
  std::map<std::string, std::vector<VertexId>> sets;

  friend void PrintTo(const MeshVariant& variant, std::ostream* out) { *out << variant.name; }
};

inline std::vector<MeshVariant> all_mesh_variants() {
  const std::map<std::string, std::vector<VertexId>> groups{{"the foot", {0, 1, 2}},
                                                            {"body", {0, 1, 2, 3, 4}}};
  const std::map<std::string, std::vector<VertexId>> first{{"first", {0, 1, 2, 3}}};
  const std::map<std::string, std::vector<VertexId>> marker{{"marker 4", {0, 1, 2}}};
  std::vector<MeshVariant> variants{
      {"MSH 2.2 text", {{"a.msh", msh2_text()}}, groups},
      {"MSH 2.2 little-endian", {{"a.msh", msh2_binary(false)}}, groups},
      {"MSH 2.2 big-endian", {{"a.msh", msh2_binary(true)}}, groups},
      {"MSH 4.1 text", {{"a.msh", msh4_text()}}, groups},
      {"MSH 4.1 little-endian", {{"a.msh", msh4_binary(false)}}, groups},
      {"MSH 4.1 big-endian", {{"a.msh", msh4_binary(true)}}, groups},
      {"VTK 3.0 text", {{"a.vtk", vtk_text()}}, {}},
      {"VTK 3.0 binary", {{"a.vtk", vtk_binary()}}, {}},
      {"VTK 5.1 text", {{"a.vtk", vtk_text_5_1()}}, {}},
      {"VTK 5.1 binary", {{"a.vtk", vtk_binary_5_1()}}, {}},
      {"VTU text", {{"a.vtu", vtu_text()}}, {}},
      {"VTU base64", {{"a.vtu", vtu_base64(false, false)}}, {}},
      {"VTU base64, big-endian, long header", {{"a.vtu", vtu_base64(true, true)}}, {}},
      {"VEGB", {{"a.vegb", vegb_bytes(small_mesh())}}, first},
  };
  for (int base : {0, 1}) {
    const std::string suffix = " from " + std::to_string(base);
    variants.push_back({"VEG" + suffix, {{"a.veg", veg_text(base)}}, first});
    variants.push_back({"VEG with TetGen files" + suffix,
                        {{"a.veg", "*VERTICES\n*INCLUDE b.node\n*ELEMENTS\nTET\n*INCLUDE b.ele\n" +
                                       veg_tail(base)},
                         {"b.node", node_text(base)},
                         {"b.ele", ele_text(base)}},
                        first});
    const std::pair<std::string, std::string> node{"a.node", node_text(base)};
    const std::pair<std::string, std::string> ele{"a.ele", ele_text(base)};
    variants.push_back({"TetGen .node" + suffix, {node, ele}, marker});
    variants.push_back({"TetGen .ele" + suffix, {ele, node}, marker});
  }
  return variants;
}

// The same text with CR LF line ends.
inline std::string with_crlf(const std::string& text) {
  std::string result;
  for (char c : text) result += c == '\n' ? std::string("\r\n") : std::string(1, c);
  return result;
}

// `text` with the one occurrence of `from` replaced; empty if there is not exactly one, so that a
// test that is out of step with the files fails.
inline std::string replaced(const std::string& text, const std::string& from,
                            const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos || text.find(from, at + 1) != std::string::npos) return "";
  return text.substr(0, at) + to + text.substr(at + from.size());
}

}  // namespace tremolo::testing
