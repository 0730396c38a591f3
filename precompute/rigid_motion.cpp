#include "precompute/rigid_motion.h"

#include <Eigen/Cholesky>
#include <Eigen/SVD>

namespace tremolo {
namespace {

// Velocity of a point at x (relative to the part's centre) under the six unit motions: three
// translations, three rotations scaled to the size of the part.
Eigen::Matrix<double, 3, 6> motions_at(const Eigen::Vector3d& x) {
  Eigen::Matrix<double, 3, 6> motions;
  motions.leftCols<3>().setIdentity();
  motions.rightCols<3>() << 0, x.z(), -x.y(), -x.z(), 0, x.x(), x.y(), -x.x(), 0;
  return motions;
}

struct Part {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double size = 0;
};

std::vector<Part> measure(const TetMesh& mesh, const std::vector<int>& part_of_vertex, int parts) {
  std::vector<Part> measured(static_cast<std::size_t>(parts));
  std::vector<int> count(measured.size(), 0);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (part_of_vertex[v] < 0) continue;
    measured[part_of_vertex[v]].centre += mesh.vertices[v];
    ++count[part_of_vertex[v]];
  }
  for (std::size_t p = 0; p < measured.size(); ++p) measured[p].centre /= count[p];
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (part_of_vertex[v] < 0) continue;
    Part& part = measured[part_of_vertex[v]];
    part.size = std::max(part.size, (mesh.vertices[v] - part.centre).norm());
  }
  return measured;
}

}  // namespace

std::vector<int> rigid_freedom(const TetMesh& mesh, const std::vector<int>& part_of_vertex,
                               int parts, const std::vector<VertexId>& fixed,
                               const std::array<std::vector<VertexId>, 3>& held_along) {
  const std::vector<Part> measured = measure(mesh, part_of_vertex, parts);
  std::vector<Eigen::Matrix<double, 6, 6>> held(measured.size(),
                                                Eigen::Matrix<double, 6, 6>::Zero());
  for (VertexId v : fixed) {
    const int p = part_of_vertex[v];
    if (p < 0) continue;
    const auto motions = motions_at((mesh.vertices[v] - measured[p].centre) / measured[p].size);
    held[p] += motions.transpose() * motions;
  }
  for (int axis = 0; axis < 3; ++axis)
    for (VertexId v : held_along[static_cast<std::size_t>(axis)]) {
      const int p = part_of_vertex[v];
      if (p < 0) continue;
      const Eigen::Matrix<double, 1, 6> motion =
          motions_at((mesh.vertices[v] - measured[p].centre) / measured[p].size).row(axis);
      held[p] += motion.transpose() * motion;
    }
  std::vector<int> freedom;
  for (const auto& matrix : held) {
    const Eigen::VectorXd values = matrix.jacobiSvd().singularValues();
    // Relative to one fully held vertex; a lever of 1e-5 of the part's size holds nothing.
    constexpr double kHeld = 1e-10;
    freedom.push_back(static_cast<int>((values.array() < kHeld).count()));
  }
  return freedom;
}

Columns rigid_modes(const TetMesh& mesh, const std::vector<int>& part_of_vertex, int parts,
                    const LocalDofs& local, Mat mass) {
  const std::vector<Part> measured = measure(mesh, part_of_vertex, parts);
  Columns modes = Columns::Zero(local.dofs(), 6 * Eigen::Index{parts});
  for (std::size_t i = 0; i < local.vertices.size(); ++i) {
    const int row = local.row_of_vertex[i];
    if (row < 0) continue;
    const auto v = static_cast<std::size_t>(local.vertices[i]);
    const int p = part_of_vertex[v];
    modes.block<3, 6>(row, 6 * p) =
        motions_at((mesh.vertices[v] - measured[p].centre) / measured[p].size);
  }
  // Twice is enough: the first pass leaves errors of the Gram matrix's condition times rounding.
  for (int pass = 0; pass < 2; ++pass) {
    const Eigen::MatrixXd gram = inner_products(modes, multiply(mass, modes));
    modes = gram.llt().matrixU().solve<Eigen::OnTheRight>(modes).eval();
  }
  return modes;
}

}  // namespace tremolo
