// Random meshes, the same for the same seed.
#pragma once

#include <algorithm>
#include <numeric>
#include <random>

#include "tests/support/meshes/box_mesh.h"

namespace tremolo::testing {

using Random = std::mt19937_64;

inline std::vector<VertexId> random_permutation(std::size_t size, Random& random) {
  std::vector<VertexId> order(size);
  std::iota(order.begin(), order.end(), VertexId{0});
  std::shuffle(order.begin(), order.end(), random);
  return order;
}

// Vertex v becomes order[v]; the tetrahedra are the same ones at the same positions.
inline TetMesh renumbered(const TetMesh& mesh, const std::vector<VertexId>& order) {
  TetMesh result;
  result.vertices.resize(mesh.vertices.size());
  for (std::size_t v = 0; v < order.size(); ++v) result.vertices[order[v]] = mesh.vertices[v];
  for (Tetrahedron tet : mesh.tetrahedra) {
    for (VertexId& v : tet) v = order[v];
    result.tetrahedra.push_back(tet);
  }
  return result;
}

// A box of one to four cells a side whose vertices are moved by at most an eighth of a cell: each
// of the six tetrahedra of a cell keeps its orientation.
inline TetMesh random_box(Random& random) {
  std::uniform_int_distribution<int> cells(1, 4);
  std::uniform_real_distribution<double> length(0.1, 0.4), shift(-0.125, 0.125);
  const std::array<int, 3> count{cells(random), cells(random), cells(random)};
  const Eigen::Vector3d cell(length(random), length(random), length(random));
  TetMesh mesh = box_mesh(count, cell.cwiseProduct(Eigen::Vector3d(count[0], count[1], count[2])));
  for (Eigen::Vector3d& x : mesh.vertices)
    for (int axis = 0; axis < 3; ++axis) x[axis] += shift(random) * cell[axis];
  std::shuffle(mesh.tetrahedra.begin(), mesh.tetrahedra.end(), random);
  return renumbered(mesh, random_permutation(mesh.vertices.size(), random));
}

// An even permutation of the corners keeps the orientation, an odd one reverses it. Returns the
// number of reversed elements.
inline std::size_t shuffle_corners(TetMesh& mesh, bool keep_orientation, Random& random) {
  std::size_t turned = 0;
  for (Tetrahedron& tet : mesh.tetrahedra) {
    const double before = signed_volume(mesh, tet);
    std::shuffle(tet.begin(), tet.end(), random);
    if (before * signed_volume(mesh, tet) > 0) continue;
    if (keep_orientation)
      std::swap(tet[0], tet[1]);
    else
      ++turned;
  }
  return turned;
}

// Vertices of no tetrahedron, some of them twins of others, among the rest. Returns how many.
inline std::size_t add_unused_vertices(TetMesh& mesh, Random& random) {
  std::uniform_int_distribution<std::size_t> count(1, 5), any(0, mesh.vertices.size() - 1);
  const std::size_t added = count(random);
  for (std::size_t n = 0; n < added; ++n)
    mesh.vertices.push_back(n % 2 == 0 ? mesh.vertices[any(random)]
                                       : Eigen::Vector3d(9, 9, 9.0 + static_cast<double>(n)));
  mesh = renumbered(mesh, random_permutation(mesh.vertices.size(), random));
  return added;
}

inline Eigen::Matrix3d random_rotation(Random& random) {
  std::normal_distribution<double> normal;
  const Eigen::Quaterniond turn(normal(random), normal(random), normal(random), normal(random));
  return turn.normalized().toRotationMatrix();
}

}  // namespace tremolo::testing
