#include "runtime/bodies/tets/elements/smooth_modes.h"

#include <algorithm>

namespace tremolo {
namespace {

// Values of a polynomial's polar form at two points: the polynomial's own where the points are
// equal.
SmoothFields polar_fields(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  SmoothFields values{};
  values[0] = 1.0F;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    values[1 + i] = static_cast<float>(0.5 * (a[i] + b[i]));
    values[4 + i] = static_cast<float>(a[i] * b[i]);
    values[7 + i] = static_cast<float>(0.5 * (a[i] * b[j] + a[j] * b[i]));
  }
  return values;
}

using ElementModes = Eigen::Matrix<double, 3 * kMostNodes, kSmoothModes>;
using ElementSquare = Eigen::Matrix<double, 3 * kMostNodes, 3 * kMostNodes>;

ElementModes element_modes(const SmoothSpace& space, const TetModelElement& element) {
  ElementModes modes = ElementModes::Zero();
  for (int n = 0; n < kMostNodes; ++n)
    for (int k = 0; k < kSmoothFields; ++k)
      modes.block<3, 3>(3 * n, 3 * k).diagonal().setConstant(space.at[element.nodes[n]][k]);
  return modes;
}

}  // namespace

SmoothSpace smooth_space(const TetModel& model) {
  SmoothSpace space;
  space.at.assign(model.nodes(), SmoothFields{});
  const BoundingBox box = model.rest_box();
  const Eigen::Vector3d centre = 0.5 * (box.low + box.high);
  const double scale = 2.0 / (box.high - box.low).maxCoeff();
  const auto place = [&](VertexId node) {
    return Eigen::Vector3d(scale *
                           (model.rest().segment<3>(3 * static_cast<Eigen::Index>(node)) - centre));
  };
  for (std::size_t v = 0; v < model.vertices(); ++v)
    space.at[v] = polar_fields(place(static_cast<VertexId>(v)), place(static_cast<VertexId>(v)));
  for (std::size_t e = 0; e < model.edges(); ++e)
    space.at[model.vertices() + e] = polar_fields(place(model.edge(e).a), place(model.edge(e).b));
  for (std::size_t i = 0; i < model.nodes(); ++i)
    if (model.held()[i] != 0) space.at[i] = SmoothFields{};

  space.stiffness.setZero();
  space.mass.setZero();
  for (const TetModelElement& element : model.elements()) {
    ElementSquare whole;
    for (int i = 0; i < kMostNodes; ++i)
      for (int j = 0; j <= i; ++j) {
        const Eigen::Matrix3d& block =
            element.stiffness[node_block(static_cast<std::size_t>(i), static_cast<std::size_t>(j))];
        whole.block<3, 3>(3 * i, 3 * j) = block;
        whole.block<3, 3>(3 * j, 3 * i) = block.transpose();
      }
    const ElementModes modes = element_modes(space, element);
    space.stiffness.noalias() += modes.transpose() * (whole * modes);
    Eigen::Matrix<double, kMostNodes, kSmoothFields> fields;
    Eigen::Matrix<double, kMostNodes, kMostNodes> mass;
    for (int i = 0; i < kMostNodes; ++i) {
      for (int k = 0; k < kSmoothFields; ++k) fields(i, k) = modes(3 * i, 3 * k);
      for (int j = 0; j < kMostNodes; ++j)
        mass(i, j) = element.element.mass * mass_share(2, std::max(i, j), std::min(i, j));
    }
    space.mass.noalias() += fields.transpose() * mass * fields;
  }
  return space;
}

SmoothMatrix smooth_matrix(const SmoothSpace& space, const Eigen::Matrix3d& turn, double mass,
                           double stiffness) {
  SmoothMatrix matrix;
  for (int k = 0; k < kSmoothFields; ++k)
    for (int l = 0; l < kSmoothFields; ++l) {
      matrix.block<3, 3>(3 * k, 3 * l).noalias() =
          stiffness * turn * space.stiffness.block<3, 3>(3 * k, 3 * l) * turn.transpose();
      matrix.block<3, 3>(3 * k, 3 * l).diagonal().array() += mass * space.mass(k, l);
    }
  return matrix;
}

}  // namespace tremolo
