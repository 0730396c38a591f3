#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "runtime/bodies/cloth/cloth_model.h"
#include "runtime/step/nodal_integrator.h"

namespace tremolo {
namespace {

using Eigen::Matrix2d;

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

// Matrices of a step with y = h omega on (omega x, v).
Matrix2d step_matrix(std::string_view name, double y, double zeta) {
  Matrix2d slope, position, kick;  // of all, of x alone, of v alone
  slope << 0.0, y, -y, -2.0 * zeta * y;
  const Matrix2d one = Matrix2d::Identity();
  position << 1.0, y, 0.0, 1.0;
  kick << 1.0, 0.0, -y, 1.0 - 2.0 * zeta * y;
  if (name == "explicit-euler") return one + slope;
  if (name == "explicit-midpoint") return one + slope + 0.5 * slope * slope;
  if (name == "symplectic-euler") return position * kick;
  if (name == "rk4") {
    const Matrix2d square = slope * slope;
    return one + slope + 0.5 * square + square * slope / 6.0 + square * square / 24.0;
  }
  if (name == "imex") {
    // Half kicks, the last one by two sweeps.
    Matrix2d half, last;
    half << 1.0, 0.0, -0.5 * y, 1.0 - zeta * y;
    last << 1.0, 0.0, -0.5 * y * (1.0 - zeta * y), 1.0 - zeta * y + zeta * zeta * y * y;
    return last * position * half;
  }
  // The sweep takes the velocities of an explicit step's end, which then move the masses.
  const Matrix2d end = one + slope;
  Matrix2d velocity;
  velocity.row(0) = one.row(0);
  velocity.row(1) = one.row(1) + slope.row(1) * end;
  return position * velocity;
}

bool grows(std::string_view name, double y, double zeta) {
  const Matrix2d g = step_matrix(name, y, zeta);
  const double half = 0.5 * g.trace(), determinant = g.determinant();
  const double root = half * half - determinant;
  const double radius = root < 0.0 ? std::sqrt(determinant) : std::abs(half) + std::sqrt(root);
  return !(radius <= 1.0 + 1e-12);
}

}  // namespace

double damped_stability_number(std::string_view name, double zeta) {
  if (std::isinf(stability_number(name))) return kNoLimit;
  // Growth below this is not detected.
  constexpr double kSmallest = 1e-3;
  double stable = kSmallest;
  if (grows(name, stable, zeta)) return 0.0;
  double beyond = stable;
  while (beyond < 4.0 && !grows(name, beyond, zeta)) {
    stable = beyond;
    beyond *= 1.002;
  }
  for (int k = 0; k < 40; ++k) {
    const double middle = 0.5 * (stable + beyond);
    (grows(name, middle, zeta) ? beyond : stable) = middle;
  }
  return stable;
}

double stable_step(std::string_view name, const ClothModel& model, const Eigen::VectorXd& x) {
  if (std::isinf(stability_number(name))) return kNoLimit;
  const bool split = name == "imex";
  const double square = largest_eigenvalue(model, x, split ? ForcePart::kSoft : ForcePart::kAll);
  if (!(square > 0.0)) return kNoLimit;
  const double omega = std::sqrt(square);
  double most = 0.0, least = kNoLimit;
  for (const SpringSet* set : {&model.structural(), &model.shear(), &model.bend()}) {
    if (set->size() == 0 || (split && set == &model.structural())) continue;
    const SpringLaw& law = set->law();
    if (!(law.stiffness > 0.0)) continue;
    most = std::max(most, law.damping / law.stiffness);
    least = std::min(least, law.damping / law.stiffness);
  }
  if (std::isinf(least)) least = 0.0;
  return std::min(damped_stability_number(name, 0.5 * most * omega),
                  damped_stability_number(name, 0.5 * least * omega)) /
         omega;
}

}  // namespace tremolo
