#include "runtime/bodies/tets/elements/tet_element.h"

#include <cstddef>

#include "runtime/bodies/tets/elements/element_turn.h"

namespace tremolo {
namespace {

Eigen::Matrix3d strain_part(const Eigen::Matrix3d& a) {
  return 0.5 * (a + a.transpose());
}

// The rotation before the minimisation.
Eigen::Matrix3d first_rotation(const TetElement& element, RotationLaw law, const NodeVectors& x,
                               const Eigen::Matrix3d& mean) {
  if (law == RotationLaw::kLeastEnergy || x.cols() == 4) return nearest_rotation(mean);
  return nearest_rotation(x.leftCols<4>() * element.geometry.gradients.transpose());
}

// Forces of the body stresses `stress` (Pa, one per sample) and the couple `couple` (J) in the
// element's frame, rotated into space.
NodeVectors turned_forces(const TetElement& element, const TetShape& shape,
                          const std::array<Eigen::Matrix3d, 4>& stresses,
                          const Eigen::Vector3d& couple) {
  const double share = 1.0 / shape.samples;
  const Eigen::Matrix3d of_couple = share * cross_matrix(couple);
  const auto points = sample_points(shape.order, 2);
  PiolaField piola(shape.order);
  for (std::size_t s = 0; s < points.size(); ++s)
    piola.add(points[s], (share * element.geometry.volume) * stresses[s] - of_couple);
  return shape.rotation * piola.forces(element.geometry);
}

// With Y_j the rigid rotation of the shape about axis j, in the element's frame: turned_j = K' Y_j,
// and slopes_j = df/dw_j = e_j x f - K' Y_j, with the body's forces f rotated about it.
void find_turn_columns(const TetElement& element, const Elasticity& elasticity,
                       const TetShape& shape, TangentParts& columns) {
  const double share = 1.0 / shape.samples;
  const double weight = share * element.geometry.volume;
  const Eigen::Matrix3d p = trace_minus(shape.mean);
  const Eigen::Matrix3d couple = share * cross_matrix(shape.couple);
  const auto points = sample_points(shape.order, 2);
  for (int j = 0; j < 3; ++j) {
    const Eigen::Matrix3d unit = cross_matrix(Eigen::Vector3d::Unit(j));
    const Eigen::Matrix3d by_couple = share * element.couple * cross_matrix(p.col(j));
    PiolaField turned(shape.order), slope(shape.order);
    for (std::size_t s = 0; s < points.size(); ++s) {
      const Eigen::Matrix3d answer =
          weight * stress(elasticity, strain_part(unit * shape.seen[s])) + by_couple;
      turned.add(points[s], answer);
      slope.add(points[s], unit * (weight * shape.stress[s] - couple) - answer);
    }
    columns.turned[j] = turned.forces(element.geometry);
    columns.slopes[j] = slope.forces(element.geometry);
  }
}

// out_IJ -= A_I M A_J^T over the lower blocks; A_I is made of the columns' node I.
void subtract_low_rank(const std::array<NodeVectors, 3>& columns, const Eigen::Matrix3d& middle,
                       NodeBlocks& out) {
  const Eigen::Index nodes = columns[0].cols();
  std::array<Eigen::Matrix3d, kMostNodes> left, right;
  for (Eigen::Index i = 0; i < nodes; ++i) {
    for (std::size_t j = 0; j < 3; ++j) left[i].col(j) = columns[j].col(i);
    right[i] = left[i] * middle;
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(nodes); ++i)
    for (std::size_t j = 0; j <= i; ++j)
      out[node_block(i, j)].noalias() -= right[i] * left[j].transpose();
}

// out_IJ += factor [g_I]^T [g_J]: the couple's own stiffness.
void add_couple(const NodeVectors& g, double factor, NodeBlocks& out) {
  for (int i = 0; i < g.cols(); ++i)
    for (int j = 0; j <= i; ++j) {
      Eigen::Matrix3d& block = out[node_block(i, j)];
      block.noalias() -= factor * g.col(j) * g.col(i).transpose();
      block.diagonal().array() += factor * g.col(i).dot(g.col(j));
    }
}

}  // namespace

TetElement make_tet_element(const std::array<Eigen::Vector3d, 4>& corners,
                            const Elasticity& elasticity, double density) {
  TetElement element;
  element.geometry = element_geometry(corners);
  // Row sums of magnitudes bound the eigenvalues; for isotropic materials they are equal to the
  // largest.
  const double largest = elasticity.tensor.cwiseAbs().rowwise().sum().maxCoeff();
  element.couple = 0.5 * largest * element.geometry.volume;
  element.mass = density * element.geometry.volume;
  return element;
}

TetShape tet_shape(const TetElement& element, const Elasticity& elasticity, RotationLaw law,
                   const NodeVectors& x) {
  TetShape shape;
  shape.order = x.cols() == 4 ? 1 : 2;
  // Relative to the first corner, so that a body far from the origin loses no more digits than its
  // position.
  const Eigen::Vector3d corner = x.col(0);
  const GradientField field =
      gradient_field(element.geometry, shape.order, [&](int node) { return x.col(node) - corner; });
  const auto points = sample_points(shape.order, 2);
  shape.samples = static_cast<int>(points.size());
  shape.mean = field(SamplePoint{});
  shape.rotation = first_rotation(element, law, x, shape.mean);
  shape.mean = shape.rotation.transpose() * shape.mean;
  for (std::size_t s = 0; s < points.size(); ++s) {
    shape.seen[s] = shape.rotation.transpose() * field(points[s]);
    shape.stress[s] = stress(elasticity, strain_part(shape.seen[s]) - Eigen::Matrix3d::Identity());
  }
  if (law == RotationLaw::kCorners || (shape.order == 1 && elasticity.isotropic)) return shape;
  shape.couple = element.couple * axial(shape.mean);
  find_least_energy(element, elasticity, shape);
  return shape;
}

double tet_energy(const TetElement& element, const TetShape& shape) {
  double density = 0.0;
  for (std::size_t s = 0; s < static_cast<std::size_t>(shape.samples); ++s)
    density += 0.5 * shape.stress[s]
                         .cwiseProduct(strain_part(shape.seen[s]) - Eigen::Matrix3d::Identity())
                         .sum();
  const double of_couple =
      shape.couple.isZero(0.0) ? 0.0 : 0.5 * shape.couple.squaredNorm() / element.couple;
  return density * element.geometry.volume / shape.samples + of_couple;
}

NodeVectors tet_force(const TetElement& element, const TetShape& shape) {
  return turned_forces(element, shape, shape.stress, shape.couple);
}

NodeVectors tet_damping_force(const TetElement& element, const Elasticity& elasticity,
                              RotationLaw law, const TetShape& shape, const NodeVectors& v) {
  const auto points = sample_points(shape.order, 2);
  const GradientField field =
      gradient_field(element.geometry, shape.order, [&v](int node) { return v.col(node); });
  const Eigen::Matrix3d back = shape.rotation.transpose();
  const double weight = element.geometry.volume / shape.samples;
  std::array<Eigen::Matrix3d, 4> rate, stresses;
  Eigen::Vector3d pull = Eigen::Vector3d::Zero();
  for (std::size_t s = 0; s < points.size(); ++s) {
    rate[s] = back * field(points[s]);
    stresses[s] = stress(elasticity, strain_part(rate[s]));
    pull += weight * axial(shape.seen[s] * stresses[s]);
  }
  if (law == RotationLaw::kCorners)
    return turned_forces(element, shape, stresses, Eigen::Vector3d::Zero());
  const Eigen::Matrix3d p = trace_minus(shape.mean);
  const Eigen::Vector3d of_mean = axial(back * field(SamplePoint{}));
  const TurnMatrices d = turn_matrices(element, elasticity, shape);
  const Eigen::Vector3d w =
      bounded_inverse(d.turned) * (pull - element.couple * p.transpose() * of_mean);
  const Eigen::Matrix3d turn = cross_matrix(w);
  for (std::size_t s = 0; s < points.size(); ++s)
    stresses[s] = stress(elasticity, strain_part(rate[s] - turn * shape.seen[s]));
  return turned_forces(element, shape, stresses, element.couple * (of_mean + p * w));
}

std::size_t pack_stiffness(const ElementStiffness& stiffness, std::span<Eigen::Matrix3d> blocks) {
  const Eigen::Index nodes = stiffness.rows() / 3;
  std::size_t count = 0;
  for (Eigen::Index i = 0; i < nodes; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) blocks[count++] = stiffness.block<3, 3>(3 * i, 3 * j);
  return count;
}

TangentParts tangent_parts(const TetElement& element, const Elasticity& elasticity,
                           const TetShape& shape, const TangentFactors& factors) {
  TangentParts parts;
  find_turn_columns(element, elasticity, shape, parts);
  const TurnMatrices d = turn_matrices(element, elasticity, shape);
  parts.of_slopes = factors.position * bounded_inverse(d.hessian);
  parts.of_turned.setZero();
  if (factors.velocity != 0.0) parts.of_turned = factors.velocity * bounded_inverse(d.turned);
  parts.gradients = node_gradients(element.geometry, shape.order, SamplePoint{});
  parts.couple = (factors.position + factors.velocity) * element.couple;
  return parts;
}

void tet_tangent(const TetElement& element, const Elasticity& elasticity, RotationLaw law,
                 const TetShape& shape, std::span<const Eigen::Matrix3d> stiffness,
                 const TangentFactors& factors, NodeBlocks& out) {
  const double both = factors.position + factors.velocity;
  const std::size_t nodes = nodes_of_order(shape.order);
  const std::size_t blocks = nodes * (nodes + 1) / 2;
  const bool exact = factors.kind == TangentKind::kExact && law == RotationLaw::kLeastEnergy;
  if (!exact) return turn_blocks(shape.rotation, both, stiffness.first(blocks), out.data());
  for (std::size_t k = 0; k < blocks; ++k) out[k] = both * stiffness[k];
  const TangentParts parts = tangent_parts(element, elasticity, shape, factors);
  add_couple(parts.gradients, parts.couple, out);
  subtract_low_rank(parts.slopes, parts.of_slopes, out);
  if (factors.velocity != 0.0) subtract_low_rank(parts.turned, parts.of_turned, out);
  turn_blocks(shape.rotation, 1.0, std::span(out).first(blocks), out.data());
}

}  // namespace tremolo
