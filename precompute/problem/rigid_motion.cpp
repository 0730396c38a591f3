#include "precompute/problem/rigid_motion.h"

#include <algorithm>

#include <Eigen/Cholesky>

#include "precompute/dense/dense_decompositions.h"

namespace tremolo {
namespace {

// Returns the velocity of a point at x (relative to the part's centre) under the six unit motions:
// three translations and three rotations, scaled by the part's size.
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
  std::vector<Part> measured(parts);
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

// Makes the rigid modes M-orthonormal. M couples no two parts, so one product with six columns
// serves all parts at once, and each part's six modes are orthonormalised separately.
void orthonormalise(Mat mass, const std::vector<int>& part_of_row, Columns& modes) {
  const Eigen::Index rows = modes.rows(), parts = modes.cols() / 6;
  Columns together(rows, 6);
  // Two passes suffice: after the first one the error is the Gram matrix's condition number times
  // rounding.
  for (int pass = 0; pass < 2; ++pass) {
    for (Eigen::Index row = 0; row < rows; ++row)
      together.row(row) = modes.row(row).segment<6>(6 * Eigen::Index{part_of_row[row]});
    const Columns inertia = multiply(mass, together);
    Eigen::MatrixXd grams = Eigen::MatrixXd::Zero(6, 6 * parts);
    for (Eigen::Index row = 0; row < rows; ++row)
      grams.middleCols<6>(6 * Eigen::Index{part_of_row[row]}).noalias() +=
          together.row(row).transpose() * inertia.row(row);
    sum_over_ranks(grams);
    std::vector<Eigen::LLT<Eigen::Matrix<double, 6, 6>>> factors;
    for (Eigen::Index part = 0; part < parts; ++part)
      factors.emplace_back(grams.middleCols<6>(6 * part));
    for (Eigen::Index row = 0; row < rows; ++row) {
      const std::size_t part = part_of_row[row];
      // x U^-1 is the solution y of U^T y = x^T.
      const Eigen::Matrix<double, 6, 1> turned =
          factors[part].matrixL().solve(together.row(row).transpose());
      modes.row(row).segment<6>(6 * static_cast<Eigen::Index>(part)) = turned.transpose();
    }
  }
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
    for (VertexId v : held_along[axis]) {
      const int p = part_of_vertex[v];
      if (p < 0) continue;
      const Eigen::Matrix<double, 1, 6> motion =
          motions_at((mesh.vertices[v] - measured[p].centre) / measured[p].size).row(axis);
      held[p] += motion.transpose() * motion;
    }
  std::vector<int> freedom;
  for (const auto& matrix : held) {
    const Eigen::VectorXd values = eigenpairs(matrix).values;
    // Relative to one fully fixed vertex; a lever arm of 1e-5 of the part's size counts as zero.
    constexpr double kHeld = 1e-10;
    freedom.push_back(static_cast<int>((values.array() < kHeld).count()));
  }
  return freedom;
}

Columns rigid_modes(const TetMesh& mesh, const std::vector<int>& part_of_vertex, int parts,
                    const LocalDofs& local, Mat mass) {
  const std::vector<Part> measured = measure(mesh, part_of_vertex, parts);
  Columns modes = Columns::Zero(local.dofs(), 6 * Eigen::Index{parts});
  std::vector<int> part_of_row(local.dofs(), 0);
  for (std::size_t i = 0; i < local.vertices.size(); ++i) {
    const int row = local.row_of_vertex[i];
    if (row < 0) continue;
    const std::size_t v = local.vertices[i];
    const int p = part_of_vertex[v];
    std::fill_n(part_of_row.begin() + row, 3, p);
    modes.block<3, 6>(row, 6 * p) =
        motions_at((mesh.vertices[v] - measured[p].centre) / measured[p].size);
  }
  orthonormalise(mass, part_of_row, modes);
  return modes;
}

}  // namespace tremolo
