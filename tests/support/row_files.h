// small_mesh() as .veg, .node and .ele files, counted from 0 or 1.
#pragma once

#include <string>

#include "tests/support/meshes/small_mesh.h"

namespace tremolo::testing {

inline std::string veg_rows(int base, bool vertices) {
  const TetMesh mesh = small_mesh();
  std::string text;
  for (int v = 0; vertices && v < 5; ++v)
    text += std::to_string(v + base) + " " + join(mesh.vertices[v]) + "\n";
  for (int t = 0; !vertices && t < 2; ++t)
    text += std::to_string(t + base) + join(mesh.tetrahedra[t], base) + "\n";
  return text;
}

inline std::string veg_tail(int base) {
  return "*MATERIAL wood # a comment\nENU, 1000, 1e6, 0.45\n*REGION\nallElements, wood\n*SET "
         "first\n" +
         std::to_string(base) + ",\n";
}

inline std::string veg_text(int base) {
  return "# a comment\n\n*VERTICES\n5 3 0 0\n" + veg_rows(base, true) +
         "\n*ELEMENTS\nTETS\n2 4 0\n" + veg_rows(base, false) + veg_tail(base);
}

inline std::string node_text(int base) {
  const TetMesh mesh = small_mesh();
  std::string text = "# points\n5 3 1 1\n";
  for (int v = 0; v < 5; ++v)
    text += "  " + std::to_string(v + base) + "  " + join(mesh.vertices[v]) + " 0.5 " +
            (v < 3 ? "4" : "0") + " # comment\n";
  return text + "# end\n";
}

inline std::string ele_text(int base) {
  const TetMesh mesh = small_mesh();
  std::string text = "2  4  1\n";
  for (int t = 0; t < 2; ++t)
    text += std::to_string(t + base) + join(mesh.tetrahedra[t], base) + " -3\n";
  return text;
}

}  // namespace tremolo::testing
