#include "precompute/vega/import.h"

namespace tremolo {

Eigen::MatrixXd reduced_mass(const TetMesh& mesh, const std::vector<double>& density,
                             const BasisRows& basis, MassKind kind) {
  // Both masses contain a sum over vertices, M_v I. The consistent mass adds one over tetrahedra:
  // rho V/20 times the outer product of (1, 1, 1, 1) with itself.
  const auto r = basis.cols();
  Eigen::VectorXd vertex_mass = Eigen::VectorXd::Zero(basis.rows() / 3);
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(r, r);
  Eigen::MatrixXd sums(r, 0);  // sqrt(rho V/20) times the sum of the corners' rows, batched
  constexpr Eigen::Index kBatch = 768;
  sums.resize(r, kBatch);
  Eigen::Index filled = 0;
  const auto add_sums = [&] {
    gram.noalias() += sums.leftCols(filled) * sums.leftCols(filled).transpose();
    filled = 0;
  };
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) {
    const Tetrahedron& tet = mesh.tetrahedra[e];
    const double mass = density[e] * signed_volume(mesh, tet);
    for (VertexId v : tet) vertex_mass[v] += kind == MassKind::kLumped ? mass / 4.0 : mass / 20.0;
    if (kind == MassKind::kLumped) continue;
    if (filled == kBatch) add_sums();
    sums.middleCols(filled, 3).setZero();
    for (VertexId v : tet)
      sums.middleCols(filled, 3) += basis.middleRows(3 * Eigen::Index{v}, 3).transpose();
    sums.middleCols(filled, 3) *= std::sqrt(mass / 20.0);
    filled += 3;
  }
  add_sums();
  constexpr Eigen::Index kVertices = 256;
  for (Eigen::Index first = 0; first < vertex_mass.size(); first += kVertices) {
    const Eigen::Index count = std::min(kVertices, vertex_mass.size() - first);
    Eigen::MatrixXd weighted = basis.middleRows(3 * first, 3 * count);
    for (Eigen::Index v = 0; v < count; ++v)
      weighted.middleRows(3 * v, 3) *= std::sqrt(vertex_mass[first + v]);
    gram.noalias() += weighted.transpose() * weighted;
  }
  return gram;
}

}  // namespace tremolo
