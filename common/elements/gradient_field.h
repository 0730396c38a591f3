// The displacement gradient of one element and the conjugate stress (element.h): a field has one
// coefficient for order 1 and four for order 2, and a sample point combines them.
#pragma once

#include <array>

#include <Eigen/Core>

#include "common/elements/element.h"

namespace tremolo {

// The coefficients G_a of one element: 1 (order 1) or 4.
struct GradientField {
  int count = 1;
  std::array<Eigen::Matrix3d, 4> at;

  Eigen::Matrix3d operator()(const SamplePoint& point) const;
};

// Returns the gradient of a field with the control values control(0), control(1), .. of the
// element's nodes; of positions in space it is the deformation gradient F.
template <class Control>
GradientField gradient_field(const ElementGeometry& element, int order, const Control& control) {
  const Eigen::Matrix<double, 4, 3> gradients = element.gradients.transpose();
  GradientField field;
  field.count = order == 1 ? 1 : 4;
  Eigen::Matrix<double, 3, 4> around;
  for (int a = 0; a < field.count; ++a) {
    for (int b = 0; b < 4; ++b) around.col(b) = control(field.count == 1 ? b : kNodeAt[a][b]);
    field.at[a] = around * gradients;
    if (field.count > 1) field.at[a] *= 2.0;
  }
  return field;
}

// Forces on the nodes of an element, N, one column a node.
using NodeForces = NodeGradients;

// Sum over samples of weight times first Piola-Kirchhoff stress, J, which is conjugate to the
// coefficients G_a: add() one sample, forces() on the nodes at the end.
struct PiolaField {
  int count = 1;
  std::array<Eigen::Matrix3d, 4> at;

  explicit PiolaField(int order);
  void add(const SamplePoint& point, const Eigen::Matrix3d& weighted);
  NodeForces forces(const ElementGeometry& element) const;
};

}  // namespace tremolo
