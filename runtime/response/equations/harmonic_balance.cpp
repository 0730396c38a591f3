#include "runtime/response/equations/harmonic_balance.h"

#include <cmath>
#include <cstdlib>
#include <numbers>

namespace tremolo {

HarmonicBalance::HarmonicBalance(const VibratingSystem& system, Eigen::Index harmonics)
    : system_(system),
      size_(system.size()),
      harmonics_(harmonics),
      columns_(2 * harmonics + 1),
      samples_(4 * harmonics + 2),
      to_samples_(columns_, samples_),
      slope_to_samples_(columns_, samples_),
      to_coefficients_(samples_, columns_),
      spectrum_weights_(samples_, 4 * harmonics + 1),
      q_(size_, samples_),
      v_(size_, samples_),
      forces_(size_, samples_),
      damping_forces_(Eigen::MatrixXd::Zero(size_, samples_)),
      tangents_(size_ * size_, samples_),
      workspace_(system.potential.make_workspace(kUseTangent)),
      evaluation_(system.potential.make_evaluation()),
      strain_rates_(system) {
  const auto N = static_cast<double>(samples_);
  for (Eigen::Index n = 0; n < samples_; ++n) {
    const double theta = 2.0 * std::numbers::pi * static_cast<double>(n) / N;
    to_samples_.col(n) = fourier_row(harmonics_, theta);
    slope_to_samples_.col(n) = fourier_slope_row(harmonics_, theta);
  }
  to_coefficients_ = (2.0 / N) * to_samples_.transpose();
  to_coefficients_.col(0) *= 0.5;
  for (Eigen::Index n = 0; n < samples_; ++n) {
    const double theta = 2.0 * std::numbers::pi * static_cast<double>(n) / N;
    spectrum_weights_.matrix().row(n) = -1.0 / N * fourier_row(2 * harmonics_, theta).transpose();
  }
}

void HarmonicBalance::sample(const FourierSeries& motion, double omega) {
  q_.noalias() = motion * to_samples_;
  if (!strain_rates_.none()) v_.noalias() = omega * motion * slope_to_samples_;
}

void HarmonicBalance::sample_forces() {
  Eigen::VectorXd q(size_), extra(size_), v(size_);
  for (Eigen::Index n = 0; n < samples_; ++n) {
    q = q_.col(n);
    system_.potential.evaluate(q, kWantForce, workspace_, evaluation_);
    forces_.col(n) = evaluation_.force;
    if (strain_rates_.none()) continue;
    v = v_.col(n);
    strain_rates_.force(q, v, extra);
    forces_.col(n) += extra;
  }
}

double HarmonicBalance::missing_share(const FourierSeries& motion, double omega) {
  // A harmonic near a resonance is estimated as if it were this far from it.
  constexpr double kLeastDistance = 0.1;
  sample(motion, omega);
  sample_forces();
  const Eigen::ArrayXd lambda = system_.potential.lambda();
  double known = 0.0, missing = 0.0;
  for (Eigen::Index k = 1; k <= 2 * harmonics_; ++k) {
    const Eigen::Index a = cosine_column(k), b = sine_column(k);
    if (k <= harmonics_) {
      known += (lambda * (motion.col(a).array().square() + motion.col(b).array().square())).sum();
      continue;
    }
    Eigen::MatrixXd to_harmonic(samples_, 2);
    for (Eigen::Index n = 0; n < samples_; ++n) {
      const double theta =
          2.0 * std::numbers::pi * static_cast<double>(k * n) / static_cast<double>(samples_);
      to_harmonic.row(n) << std::cos(theta), std::sin(theta);
    }
    const double speed = static_cast<double>(k) * omega;
    const Eigen::ArrayXd stiffness =
        (lambda - speed * speed).abs().max(kLeastDistance * lambda.max(speed * speed));
    const Eigen::ArrayXd squares =
        (forces_ * to_harmonic * (2.0 / static_cast<double>(samples_))).rowwise().squaredNorm();
    missing += (lambda * squares / stiffness.square()).sum();
  }
  return known > 0.0 ? std::sqrt(missing / known) : 0.0;
}

double HarmonicBalance::strain_share(const FourierSeries& motion, Eigen::Index first) const {
  const Eigen::VectorXd roots = system_.potential.lambda().cwiseSqrt();
  const double all = (roots.asDiagonal() * motion.rightCols(2 * harmonics_)).norm();
  const Eigen::Index columns = 2 * (harmonics_ - first + 1);
  return all > 0.0 ? (roots.asDiagonal() * motion.rightCols(columns)).norm() / all : 0.0;
}

void HarmonicBalance::residual(const FourierSeries& motion, double omega, double xi,
                               const FourierSeries& force, FourierSeries& out) {
  sample(motion, omega);
  sample_forces();
  out.noalias() = forces_ * to_coefficients_;
  out -= force;
  for (Eigen::Index k = 1; k <= harmonics_; ++k) {
    const double speed = static_cast<double>(k) * omega;
    const auto a = motion.col(cosine_column(k)), b = motion.col(sine_column(k));
    const auto rates = (system_.damping.array() + xi) * speed;
    out.col(cosine_column(k)).array() += rates * b.array() - speed * speed * a.array();
    out.col(sine_column(k)).array() -= rates * a.array() + speed * speed * b.array();
  }
}

void HarmonicBalance::sample_tangents() {
  const bool rates = !strain_rates_.none();
  if (rates) by_rate_.resize(size_ * size_, samples_);
  Eigen::VectorXd q(size_), v(size_), extra(size_);
  Eigen::MatrixXd by_q(size_, size_), by_v(size_, size_);
  for (Eigen::Index n = 0; n < samples_; ++n) {
    q = q_.col(n);
    system_.potential.evaluate(q, kWantTangent, workspace_, evaluation_);
    if (rates) {
      v = v_.col(n);
      strain_rates_.derivatives(q, v, by_q, by_v);
      evaluation_.tangent += by_q;
      by_rate_.matrix().col(n) = by_v.reshaped();
      strain_rates_.force(q, v, extra);
      damping_forces_.col(n) = extra;
    }
    tangents_.matrix().col(n) = evaluation_.tangent.reshaped();
  }
}

// The block of rows cos k and columns cos l is C_(k-l) + C_(k+l), and so on, with the means C_m,
// S_m of the samples times cos m theta, sin m theta: the columns of the spectrum.
void HarmonicBalance::add_blocks(const PaddedMatrix& samples, bool slope, double factor,
                                 Eigen::Ref<Eigen::MatrixXd> out) {
  spectrum_.resize(size_ * size_, 4 * harmonics_ + 1);
  spectrum_.subtract_product(samples, spectrum_weights_);
  const auto C = [&](Eigen::Index m) {
    return spectrum_.matrix().col(m == 0 ? 0 : cosine_column(m)).reshaped(size_, size_);
  };
  const auto S = [&](Eigen::Index m) {
    return spectrum_.matrix().col(sine_column(m)).reshaped(size_, size_);
  };
  const auto at = [&](Eigen::Index k, Eigen::Index l) {
    return out.block(k * size_, l * size_, size_, size_);
  };
  for (Eigen::Index l = slope ? 1 : 0; l <= harmonics_; ++l)
    for (Eigen::Index k = 0; k <= harmonics_; ++k) {
      // Row 0 has half the weight of the others. S_0 is zero, and its column another one's.
      const double weight = (k == 0 ? 0.5 : 1.0) * factor;
      const double order = slope ? weight * static_cast<double>(l) : weight;
      const double odd = k > l ? 1.0 : k < l ? -1.0 : 0.0;
      const Eigen::Index less = std::abs(k - l), more = k + l;
      const Eigen::Index row = k == 0 ? 0 : cosine_column(k),
                         column = l == 0 ? 0 : cosine_column(l);
      // With `slope` the columns are those of the derivatives -l sin and l cos.
      const Eigen::Index cosines = slope ? column + 1 : column, sines = slope ? column : column + 1;
      const double sign = slope ? -order : order;
      at(row, cosines) += order * (C(less) + C(more));
      if (k > 0) at(row + 1, cosines) += order * (S(more) + odd * S(less));
      if (l == 0) continue;
      at(row, sines) += sign * (S(more) - odd * S(less));
      if (k > 0) at(row + 1, sines) += sign * (C(less) - C(more));
    }
}

void HarmonicBalance::jacobian(const FourierSeries& motion, double omega, double xi,
                               Eigen::Ref<Eigen::MatrixXd> out,
                               Eigen::Ref<Eigen::VectorXd> by_omega, Eigen::VectorXd* by_xi) {
  sample(motion, omega);
  sample_tangents();
  const Eigen::Index n = unknowns();
  auto J = out.topLeftCorner(n, n);
  J.setZero();
  add_blocks(tangents_, false, 1.0, J);
  by_omega.head(n).setZero();
  if (!strain_rates_.none()) {
    add_blocks(by_rate_, true, omega, J);
    // The force is linear in the velocity, which is linear in omega.
    by_omega.head(n) = (damping_forces_ * to_coefficients_ / omega).reshaped();
  }
  if (by_xi != nullptr) by_xi->setZero(n);
  for (Eigen::Index k = 1; k <= harmonics_; ++k) {
    const auto order = static_cast<double>(k);
    const double speed = order * omega;
    const Eigen::Index a = cosine_column(k) * size_, b = sine_column(k) * size_;
    for (Eigen::Index i = 0; i < size_; ++i) {
      const double rate = system_.damping[i] + xi;
      const double cosine = motion(i, cosine_column(k)), sine = motion(i, sine_column(k));
      J(a + i, a + i) -= speed * speed;
      J(b + i, b + i) -= speed * speed;
      J(a + i, b + i) += speed * rate;
      J(b + i, a + i) -= speed * rate;
      by_omega[a + i] += order * rate * sine - 2.0 * order * speed * cosine;
      by_omega[b + i] -= order * rate * cosine + 2.0 * order * speed * sine;
      if (by_xi == nullptr) continue;
      (*by_xi)[a + i] = speed * sine;
      (*by_xi)[b + i] = -speed * cosine;
    }
  }
}

}  // namespace tremolo
