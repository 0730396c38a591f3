#include "runtime/response/floquet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include <Eigen/Eigenvalues>

#include "runtime/math/dense/dense_lu.h"

namespace tremolo {
namespace {

constexpr int kStages = 3;
const double kRoot15 = std::sqrt(15.0);
const std::array<double, kStages> kNodes = {0.5 - kRoot15 / 10.0, 0.5, 0.5 + kRoot15 / 10.0};
const std::array<double, kStages> kWeights = {5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0};

// The inverse of the Gauss method's matrix A, its square, and the row sums of both.
struct Tableau {
  Eigen::Matrix3d inverse, square;
  Eigen::Vector3d inverse_sums, square_sums;
  // The end of a step is weights . A^-1 and weights . A^-2 of its stages.
  Eigen::Vector3d end_weights, end_square_weights;
};
const Tableau& tableau() {
  static const Tableau values = [] {
    Eigen::Matrix3d A;
    A << 5.0 / 36.0, 2.0 / 9.0 - kRoot15 / 15.0, 5.0 / 36.0 - kRoot15 / 30.0,
        5.0 / 36.0 + kRoot15 / 24.0, 2.0 / 9.0, 5.0 / 36.0 - kRoot15 / 24.0,
        5.0 / 36.0 + kRoot15 / 30.0, 2.0 / 9.0 + kRoot15 / 15.0, 5.0 / 36.0;
    Tableau t;
    t.inverse = A.inverse();
    t.square = t.inverse * t.inverse;
    t.inverse_sums = t.inverse.rowwise().sum();
    t.square_sums = t.square.rowwise().sum();
    const Eigen::Map<const Eigen::Vector3d> weights(kWeights.data());
    t.end_weights = t.inverse.transpose() * weights;
    t.end_square_weights = t.square.transpose() * weights;
    return t;
  }();
  return values;
}

// Weights (samples x nodes) that interpolate a trigonometric polynomial of degree 2H from its
// 4H + 2 samples to the nodes of all steps, with a minus sign for subtract_product().
PaddedMatrix node_weights(Eigen::Index harmonics, int steps) {
  const Eigen::Index samples = 4 * harmonics + 2, nodes = Eigen::Index{kStages} * steps;
  PaddedMatrix weights(samples, nodes);
  const double order = 2.0 * static_cast<double>(harmonics) + 0.5;
  const auto N = static_cast<double>(samples);
  for (Eigen::Index node = 0; node < nodes; ++node)
    for (Eigen::Index n = 0; n < samples; ++n) {
      double turn =
          (static_cast<double>(node / kStages) + kNodes[static_cast<std::size_t>(node % kStages)]) /
              steps -
          static_cast<double>(n) / N;
      turn -= std::round(turn);
      const double half = std::sin(std::numbers::pi * turn);
      // Dirichlet's kernel.
      const double kernel = std::abs(half) < 1e-9
                                ? 2.0 * order
                                : std::sin(2.0 * std::numbers::pi * order * turn) / half;
      weights.matrix()(n, node) = -kernel / N;
    }
  return weights;
}

// One step of length h: the deviation's d and h v, each r x 2r, advance in place. The unknowns are
// the displacements D_i of the stages. With B = A^-1, C = B B, and e = (1, 1, 1),
//
//     sum_j (C_ij + h B_ij R_i) D_j + h^2 K_i D_i = (C e)_i d + (B e)_i (h v + h R_i d),
//
// so that K multiplies nothing but the unknowns. The velocity is a difference of displacements: its
// rounding error grows with the number of steps, to 1e-8 with 512.
class GaussStep {
 public:
  explicit GaussStep(Eigen::Index r)
      : matrix_(kStages * r, kStages * r), stages_(kStages * r, 2 * r) {}

  // stiffness: h^2 K_i as the columns first, first + 1, first + 2 (r x r by columns). rate: h R_i.
  void take(const PaddedMatrix::ConstMap& stiffness, Eigen::Index first,
            const std::array<Eigen::MatrixXd, kStages>* rates, const Eigen::VectorXd& rate,
            Eigen::MatrixXd& d, Eigen::MatrixXd& v) {
    const Eigen::Index r = d.rows();
    const Tableau& t = tableau();
    matrix_.setZero();
    for (int i = 0; i < kStages; ++i) {
      auto here = stages_.middleRows(i * r, r);
      here = t.square_sums[i] * d + t.inverse_sums[i] * v;
      for (int j = 0; j < kStages; ++j) {
        auto block = matrix_.block(i * r, j * r, r, r);
        if (i == j) block = stiffness.col(first + i).reshaped(r, r);
        block.diagonal().array() += t.square(i, j) + t.inverse(i, j) * rate.array();
        if (rates != nullptr) block += t.inverse(i, j) * (*rates)[static_cast<std::size_t>(i)];
      }
      here += t.inverse_sums[i] * (rate.asDiagonal() * d);
      if (rates != nullptr) here += t.inverse_sums[i] * ((*rates)[static_cast<std::size_t>(i)] * d);
    }
    factor_.compute(matrix_);
    factor_.solve_in_place(stages_);
    finish(d, v);
  }

 private:
  // The end of the step from its stages: with the weights b,
  // d' = d + b B (D - e d) and h v' = h v + b (C (D - e d) - B e h v).
  void finish(Eigen::MatrixXd& d, Eigen::MatrixXd& v) const {
    const Eigen::Index r = d.rows();
    const Tableau& t = tableau();
    v = (1.0 - t.end_weights.sum()) * v - t.end_square_weights.sum() * d;
    d *= 1.0 - t.end_weights.sum();
    for (int i = 0; i < kStages; ++i) {
      v += t.end_square_weights[i] * stages_.middleRows(i * r, r);
      d += t.end_weights[i] * stages_.middleRows(i * r, r);
    }
  }

  Eigen::MatrixXd matrix_, stages_;
  DenseLu factor_;
};

}  // namespace

int floquet_steps(Eigen::Index harmonics) {
  return static_cast<int>(std::max<Eigen::Index>(32, 4 * harmonics));
}

Floquet::Floquet(const VibratingSystem& system)
    : system_(system),
      workspace_(system.potential.make_workspace(kUseTangent)),
      evaluation_(system.potential.make_evaluation()),
      strain_rates_(system) {}

const PaddedMatrix& Floquet::weights_of(Eigen::Index harmonics, int steps) {
  for (const Weights& known : weights_)
    if (known.harmonics == harmonics && known.steps == steps) return known.weights;
  weights_.push_back({harmonics, steps, node_weights(harmonics, steps)});
  return weights_.back().weights;
}

void Floquet::sample(const FourierSeries& motion, double omega) {
  const Eigen::Index r = system_.size(), H = harmonics_of(motion), samples = 4 * H + 2;
  samples_.resize(r * r, samples);
  if (!strain_rates_.none()) rate_samples_.resize(r * r, samples);
  Eigen::MatrixXd by_q(r, r), by_v(r, r);
  for (Eigen::Index n = 0; n < samples; ++n) {
    const double theta =
        2.0 * std::numbers::pi * static_cast<double>(n) / static_cast<double>(samples);
    q_ = motion * fourier_row(H, theta);
    system_.potential.evaluate(q_, kWantTangent, workspace_, evaluation_);
    if (!strain_rates_.none()) {
      const Eigen::VectorXd v = omega * motion * fourier_slope_row(H, theta);
      strain_rates_.derivatives(q_, v, by_q, by_v);
      evaluation_.tangent += by_q;
      rate_samples_.matrix().col(n) = by_v.reshaped();
    }
    samples_.matrix().col(n) = evaluation_.tangent.reshaped();
  }
}

Eigen::MatrixXd Floquet::monodromy(const FourierSeries& motion, double omega, int steps) {
  const Eigen::Index r = system_.size(), nodes = Eigen::Index{kStages} * steps;
  const double h = 2.0 * std::numbers::pi / static_cast<double>(steps);
  sample(motion, omega);
  const PaddedMatrix& weights = weights_of(harmonics_of(motion), steps);
  at_nodes_.resize(r * r, nodes);
  at_nodes_.subtract_product(samples_, weights);
  at_nodes_.matrix() *= h * h / (omega * omega);
  const bool with_rates = !strain_rates_.none();
  if (with_rates) {
    rates_at_nodes_.resize(r * r, nodes);
    rates_at_nodes_.subtract_product(rate_samples_, weights);
    rates_at_nodes_.matrix() *= h / omega;
  }
  const Eigen::VectorXd rate = h / omega * system_.damping;
  std::array<Eigen::MatrixXd, kStages> rates;
  Eigen::MatrixXd d = Eigen::MatrixXd::Identity(r, 2 * r), v = Eigen::MatrixXd::Zero(r, 2 * r);
  v.rightCols(r).diagonal().setConstant(h);
  GaussStep step(r);
  for (Eigen::Index first = 0; first < nodes; first += kStages) {
    if (with_rates)
      for (int i = 0; i < kStages; ++i)
        rates[static_cast<std::size_t>(i)] = rates_at_nodes_.matrix().col(first + i).reshaped(r, r);
    step.take(std::as_const(at_nodes_).matrix(), first, with_rates ? &rates : nullptr, rate, d, v);
  }
  Eigen::MatrixXd result(2 * r, 2 * r);
  result << d, v / h;
  return result;
}

Eigen::VectorXcd Floquet::multipliers(const FourierSeries& motion, double omega, int steps) {
  Eigen::MatrixXd matrix = monodromy(motion, omega, steps);
  // In units in which the stiff coordinates' velocities are as large as their displacements.
  const Eigen::Index r = system_.size();
  const Eigen::VectorXd speed = (system_.potential.lambda().cwiseSqrt() / omega).cwiseMax(1e-3);
  matrix.bottomRows(r) = speed.cwiseInverse().asDiagonal() * matrix.bottomRows(r);
  matrix.rightCols(r) = matrix.rightCols(r) * speed.asDiagonal();
  Eigen::VectorXcd values = Eigen::EigenSolver<Eigen::MatrixXd>(matrix, false).eigenvalues();
  std::sort(values.begin(), values.end(),
            [](const auto& a, const auto& b) { return std::abs(a) > std::abs(b); });
  return values;
}

const char* name_of(BifurcationKind kind) {
  constexpr std::array<const char*, 4> kNames = {"fold", "branch point", "period doubling",
                                                 "Neimark-Sacker"};
  return kNames[static_cast<std::size_t>(kind)];
}

BifurcationKind kind_of_crossing(std::complex<double> multiplier) {
  // At the crossing itself |multiplier| is 1, so that only its angle decides.
  constexpr double kReal = 1e-3;  // rad
  const double angle = std::abs(std::arg(multiplier));
  if (angle < kReal) return BifurcationKind::kBranch;
  if (angle > std::numbers::pi - kReal) return BifurcationKind::kPeriodDoubling;
  return BifurcationKind::kNeimarkSacker;
}

}  // namespace tremolo
