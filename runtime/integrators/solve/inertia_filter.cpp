#include "runtime/integrators/solve/inertia_filter.h"

#include <algorithm>
#include <cmath>

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kEp2Limit = 1.2;  // of h omega/2: x cot x stays above 0.46

// Damping is strong where it changes J's diagonal by more than this, relative.
constexpr double kStrongDamping = 0.02;

}  // namespace

double cotangent_weight(double x) {
  x = std::min(x, kEp2Limit);
  return x < 1e-4 ? 1.0 - x * x / 3.0 : x / std::tan(x);
}

double rational_weight(double x) {
  return filter_value(kRobustShape, x * x);
}

double stiff_share(double damping) {
  const double x = std::clamp(4.0 * damping - 1.0, 0.0, 1.0);
  return 1.0 - x * x * (3.0 - 2.0 * x);
}

InertiaDamping make_inertia_damping(const Model& model, const IntegratorOptions& options,
                                    InertiaWeight at_rest) {
  const double h = options.step;
  const Index r = model.modes();
  InertiaDamping damping;
  damping.D = damping_rates(model.lambda(), options.alpha, options.beta);
  damping.present = damping.D.maxCoeff() > 0.0;
  damping.z = (0.25 * h * h) * model.lambda();
  if (!model.potential().linear()) damping.strain = 2.0 * options.beta / h;
  for (VectorXd* v : {&damping.theta, &damping.n, &damping.shift, &damping.g, &damping.slope})
    v->setZero(r);
  for (Index i = 0; i < r; ++i) {
    const double c = h * damping.D[i], w = h * std::sqrt(model.lambda()[i]);
    const DampedWeights whole = damped_weights(c, w, at_rest);
    const double rest = at_rest(0.5 * w);
    const double share = damping.strain > 0.0 ? stiff_share(options.beta * (w * w / h)) : 1.0;
    const double theta = share * whole.theta;
    const double n = share == 1.0 ? whole.n : rest + share * (whole.n - rest);
    damping.theta[i] = theta;
    damping.n[i] = n;
    damping.shift[i] = n - rest;
    damping.g[i] = 1.0 + 2.0 * theta * c;
    damping.slope[i] = n * n / damping.g[i] + 0.5 * c;
  }
  return damping;
}

DampedMatrixFilter::DampedMatrixFilter(const InertiaDamping& damping)
    : shift_(damping.shift),
      shifted_(shift_),
      slope_(damping.slope),
      factors_(shift_.size(), shift_.size()),
      filter_(shift_.size(), kRobustShape),
      factor_(shift_.size()) {
  const VectorXd& z = damping.z;
  const VectorXd weight = damping.n.cwiseProduct(damping.g.cwiseInverse());
  for (Index j = 0; j < shift_.size(); ++j)
    for (Index i = 0; i < shift_.size(); ++i)
      factors_(i, j) =
          1.0 + damping.strain + filter_slope(kRobustShape, z[i], z[j]) * (weight[i] + weight[j]);
  const Eigen::ArrayXd undamped = (damping.n - damping.shift).array().square();
  const Eigen::ArrayXd change = (slope_.array() - undamped).abs() / (undamped + z.array());
  strong_ = change.maxCoeff() > kStrongDamping;
  slope_.array() += (1.0 - factors_.diagonal().array()) * z.array();
}

}  // namespace tremolo
