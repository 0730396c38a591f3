#include "common/elements/gradient_field.h"

namespace tremolo {

Eigen::Matrix3d GradientField::operator()(const SamplePoint& point) const {
  if (count == 1) return at[0];
  return point.lambda[0] * at[0] + point.lambda[1] * at[1] + point.lambda[2] * at[2] +
         point.lambda[3] * at[3];
}

PiolaField::PiolaField(int order) : count(order == 1 ? 1 : 4) {
  at.fill(Eigen::Matrix3d::Zero());
}

void PiolaField::add(const SamplePoint& point, const Eigen::Matrix3d& weighted) {
  if (count == 1) {
    at[0] += weighted;
    return;
  }
  for (std::size_t a = 0; a < 4; ++a) at[a] += point.lambda[a] * weighted;
}

NodeForces PiolaField::forces(const ElementGeometry& element) const {
  if (count == 1) return at[0] * element.gradients;
  NodeForces forces(3, kMostNodes);
  for (int a = 0; a < 4; ++a) {
    forces.col(a) = 2.0 * at[a] * element.gradients.col(a);
    for (int b = a + 1; b < 4; ++b)
      forces.col(kNodeAt[a][b]) =
          2.0 * (at[a] * element.gradients.col(b) + at[b] * element.gradients.col(a));
  }
  return forces;
}

}  // namespace tremolo
