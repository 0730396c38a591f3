// A tetrahedral mesh as plain values.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/mesh/given_vertices.h"

namespace tremolo {

using VertexId = std::int32_t;
using Tetrahedron = std::array<VertexId, 4>;
using TetEdges = std::array<VertexId, 6>;
using Triangle = std::array<VertexId, 3>;

// An edge of a quadratic mesh: the vertex in its middle, and its two ends,
// a < b.
struct MeshEdge {
  VertexId point = 0;
  VertexId a = 0;
  VertexId b = 0;
};

using Colour = std::array<std::uint8_t, 4>;  // red, green, blue, alpha

// vertices: n rest positions in metres. tetrahedra: m quadruples of indices into vertices,
// positively oriented once mesh_check.h has seen them: det[x1-x0, x2-x0, x3-x0] > 0.
// node_sets: named vertex sets of the source file, each sorted and without repeats.
// colours: painted on the vertices, n or none; alpha 0 is bare.
// region_of: empty, or for each tetrahedron an index into region_names, -1 if it is in none.
// region_names: the source file's names of its parts of different material, each once.
// edges: of a quadratic mesh (edge_points.h), ascending by their points; none of a linear one.
// edge_points: empty, or of each tetrahedron the points of its edges in the order of kTetEdges.
// solids: tetrahedra inside the objects and materials of a surface, by name; each ascending.
// given: of a mesh that was cut from a surface, what the numbers of its vertices mean.
struct TetMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Tetrahedron> tetrahedra;
  std::map<std::string, std::vector<VertexId>> node_sets;
  std::vector<Colour> colours = {};
  std::vector<std::int32_t> region_of = {};
  std::vector<std::string> region_names = {};
  std::vector<MeshEdge> edges = {};
  std::vector<TetEdges> edge_points = {};
  std::map<std::string, std::vector<std::int32_t>> solids = {};
  std::shared_ptr<const GivenVertices> given = {};
};

// Corners of a tetrahedron between which its six edges run.
inline constexpr std::array<std::array<int, 2>, 6> kTetEdges = {
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

// Six times the volume is the determinant of the edge matrix; the sign is the orientation.
inline double signed_volume(const TetMesh& mesh, const Tetrahedron& tet) {
  const Eigen::Vector3d& origin = mesh.vertices[tet[0]];
  const Eigen::Vector3d a = mesh.vertices[tet[1]] - origin;
  const Eigen::Vector3d b = mesh.vertices[tet[2]] - origin;
  const Eigen::Vector3d c = mesh.vertices[tet[3]] - origin;
  return a.dot(b.cross(c)) / 6.0;
}

// Axis-aligned bounding box of all vertices; {0, 0} for an empty mesh.
struct BoundingBox {
  Eigen::Vector3d low = Eigen::Vector3d::Zero();
  Eigen::Vector3d high = Eigen::Vector3d::Zero();
  double diagonal() const { return (high - low).norm(); }
};

inline BoundingBox bounding_box(const std::vector<Eigen::Vector3d>& vertices) {
  if (vertices.empty()) return {};
  BoundingBox box{vertices.front(), vertices.front()};
  for (const Eigen::Vector3d& x : vertices) {
    box.low = box.low.cwiseMin(x);
    box.high = box.high.cwiseMax(x);
  }
  return box;
}

}  // namespace tremolo
