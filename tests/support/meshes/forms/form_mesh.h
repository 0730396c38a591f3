// The bar that writer_forms.h writes as each program does.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/meshes/box_mesh.h"
#include "tests/support/meshes/small_mesh.h"

namespace tremolo::testing {

// One mesh as one program writes it. files: {name, bytes}; the first is the one to read.
// foot: the name under which the vertices at x = 0 are a set; empty: the form has no sets.
// regions: the names of the halves below and above the middle along x; empty: the form has none.
struct WriterForm {
  std::string writer;
  std::string form;
  std::vector<std::pair<std::string, std::string>> files;
  std::string foot = "";
  std::vector<std::string> regions = {};
  bool quadratic = false;
};

// 1 x 0.5 x 0.25 m: coordinates that eight characters hold exactly. Its lowest mode is simple.
struct FormBar {
  TetMesh mesh = box_mesh({4, 2, 2}, {1.0, 0.5, 0.25});
  std::vector<VertexId> foot = vertices_on_plane(mesh, 0, 0.0);
  std::vector<Triangle> foot_triangles;  // of the boundary at x = 0
  std::vector<int> half;                 // of each tetrahedron: 0 or 1

  FormBar() {
    for (const Tetrahedron& tet : mesh.tetrahedra) {
      double x = 0;
      std::vector<VertexId> low;
      for (const VertexId v : tet) {
        x += mesh.vertices[v].x() / 4;
        if (mesh.vertices[v].x() == 0) low.push_back(v);
      }
      half.push_back(x < 0.5 ? 0 : 1);
      if (low.size() == 3) foot_triangles.push_back({low[0], low[1], low[2]});
    }
  }
  std::vector<std::size_t> tets_of_half(int which) const {
    std::vector<std::size_t> tets;
    for (std::size_t t = 0; t < half.size(); ++t)
      if (half[t] == which) tets.push_back(t);
    return tets;
  }
};

// Corners and edge points of each tetrahedron: edges 01, 12, 02, 03, 13, 23, as VTK, Abaqus and
// Nastran order them.
struct QuadraticBar {
  TetMesh mesh;
  std::vector<std::array<VertexId, 10>> cells;

  QuadraticBar() {
    mesh = FormBar().mesh;
    mesh = of_order(std::move(mesh), 2);
    constexpr std::array<std::size_t, 6> kOurs = {0, 3, 1, 2, 4, 5};
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
      std::array<VertexId, 10> cell{};
      for (std::size_t c = 0; c < 4; ++c) cell[c] = mesh.tetrahedra[t][c];
      for (std::size_t e = 0; e < 6; ++e) cell[4 + e] = mesh.edge_points[t][kOurs[e]];
      cells.push_back(cell);
    }
  }
};

template <class Ids>
inline std::string joined(const Ids& ids, const std::string& separator, int base = 0) {
  std::string text;
  for (const auto id : ids)
    text += (text.empty() ? "" : separator) + std::to_string(static_cast<long>(id) + base);
  return text;
}

}  // namespace tremolo::testing
