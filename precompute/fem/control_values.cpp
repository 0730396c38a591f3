#include "precompute/fem/control_values.h"

namespace tremolo {
namespace {

auto at(BasisRows& rows, VertexId v) {
  return rows.middleRows<3>(3 * Eigen::Index{v});
}

}  // namespace

void to_displacements(const TetMesh& mesh, BasisRows& rows) {
  for (const MeshEdge& edge : mesh.edges)
    at(rows, edge.point) =
        0.25 * (at(rows, edge.a) + 2.0 * at(rows, edge.point) + at(rows, edge.b));
}

void to_control_values(const TetMesh& mesh, BasisRows& rows) {
  for (const MeshEdge& edge : mesh.edges)
    at(rows, edge.point) = 2.0 * at(rows, edge.point) - 0.5 * (at(rows, edge.a) + at(rows, edge.b));
}

}  // namespace tremolo
