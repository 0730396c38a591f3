#include "tests/lab/known/resonance.h"

#include <cmath>

#include "tests/lab/known/quartic_model.h"
#include "tests/lab/work/failure.h"

namespace tremolo::known {

double spectral_radius(const Eigen::Matrix2d& map) {
  const double half = 0.5 * map.trace();
  const double determinant = map.determinant();
  const double root = half * half - determinant;
  return root <= 0.0 ? std::sqrt(std::abs(determinant)) : std::abs(half) + std::sqrt(root);
}

Eigen::Matrix2d respa_map(double h, double k) {
  const double c = std::cos(h);
  const double s = std::sin(h);
  const double kick = 0.5 * h * k;
  Eigen::Matrix2d map;
  map << c - kick * s, s,  //
      -s - 2.0 * kick * c + kick * kick * s, c - kick * s;
  return map;
}

std::optional<Eigen::Matrix2d> linear_map(std::string_view method, double h, double k) {
  BasisData data = quadratic_basis(Eigen::Vector2d(kNoStiffness, 1.0));
  add_monomial(data, 0.5 * k, 0, 0, 1, 1);
  IntegratorOptions options{.step = h};
  options.split = {.rule = SplitRule::kCount, .count = 1};
  options.tolerance = 1e-13;
  options.halvings = 0;  // a step in parts is another map
  const std::unique_ptr<Integrator> integrator =
      or_fail(make_integrator(method, or_fail(Model::from_data(data)), options));
  constexpr double kSmall = 1e-6;
  Eigen::Matrix2d map;
  for (int column = 0; column < 2; ++column) {
    integrator->reset();
    State state{Eigen::Vector2d(1.0, column == 0 ? kSmall : 0.0),
                Eigen::Vector2d(0.0, column == 1 ? kSmall : 0.0)};
    if (!integrator->step(state, make_step_load(2)).converged) return std::nullopt;
    map.col(column) << state.q[1] / kSmall, state.p[1] / kSmall;
  }
  return map;
}

}  // namespace tremolo::known
