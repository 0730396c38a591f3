#include "runtime/response/floquet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include <Eigen/Eigenvalues>

#include "runtime/math/dense/dense_lu.h"

namespace tremolo {
namespace {

constexpr int kStages = 3;
const double kRoot15 = std::sqrt(15.0);
const std::array<double, kStages> kNodes = {0.5 - kRoot15 / 10.0, 0.5, 0.5 + kRoot15 / 10.0};
const std::array<double, kStages> kWeights = {5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0};

// The coefficients of the Gauss method, and their square, for second-order equations.
struct Tableau {
  Eigen::Matrix3d A, square;
};
const Tableau& tableau() {
  static const Tableau values = [] {
    Tableau t;
    t.A << 5.0 / 36.0, 2.0 / 9.0 - kRoot15 / 15.0, 5.0 / 36.0 - kRoot15 / 30.0,
        5.0 / 36.0 + kRoot15 / 24.0, 2.0 / 9.0, 5.0 / 36.0 - kRoot15 / 24.0,
        5.0 / 36.0 + kRoot15 / 30.0, 2.0 / 9.0 + kRoot15 / 15.0, 5.0 / 36.0;
    t.square = t.A * t.A;
    return t;
  }();
  return values;
}

// The coefficients of d'' = -R d' - K d at one node, in the time theta = omega t.
struct Coefficients {
  Eigen::MatrixXd stiffness;  // K / omega^2
  Eigen::MatrixXd rate;       // R / omega
};

// Evaluates the coefficients along a motion.
class AlongMotion {
 public:
  AlongMotion(const VibratingSystem& system, const FourierSeries& motion, double omega)
      : system_(system),
        motion_(motion),
        omega_(omega),
        workspace_(system.potential.make_workspace(kUseTangent)),
        evaluation_(system.potential.make_evaluation()),
        strain_rates_(system) {}

  void at(double theta, Coefficients& out) {
    const Eigen::Index H = harmonics_of(motion_);
    q_ = motion_ * fourier_row(H, theta);
    system_.potential.evaluate(q_, kWantTangent, workspace_, evaluation_);
    out.rate = (system_.damping / omega_).asDiagonal();
    if (!strain_rates_.none()) {
      v_ = omega_ * motion_ * fourier_slope_row(H, theta);
      by_q_.resize(q_.size(), q_.size());
      by_v_.resize(q_.size(), q_.size());
      strain_rates_.derivatives(q_, v_, by_q_, by_v_);
      evaluation_.tangent += by_q_;
      out.rate += by_v_ / omega_;
    }
    out.stiffness = evaluation_.tangent / (omega_ * omega_);
  }

 private:
  const VibratingSystem& system_;
  const FourierSeries& motion_;
  double omega_;
  PotentialWorkspace workspace_;
  Evaluation evaluation_;
  StrainRateForce strain_rates_;
  Eigen::VectorXd q_, v_;
  Eigen::MatrixXd by_q_, by_v_;
};

// Steps of length h: the deviation's rows d and v advance in place, each r x 2r. The unknowns are
// the accelerations a_i of the stages,
//
//     a_i + h sum_j A_ij R_i a_j + h^2 sum_j (A^2)_ij K_i a_j = -R_i v - K_i (d + c_i h v).
class GaussStep {
 public:
  explicit GaussStep(Eigen::Index r)
      : matrix_(kStages * r, kStages * r),
        right_(kStages * r, 2 * r),
        square_(r, r),
        columns_(r, 2 * r) {}

  void take(const std::array<Coefficients, kStages>& at, double h, Eigen::MatrixXd& d,
            Eigen::MatrixXd& v) {
    const Eigen::Index r = d.rows();
    const auto& [A, square] = tableau();
    for (int i = 0; i < kStages; ++i) {
      const Coefficients& here = at[static_cast<std::size_t>(i)];
      for (int j = 0; j < kStages; ++j)
        matrix_.block(i * r, j * r, r, r) =
            (h * A(i, j)) * here.rate + (h * h * square(i, j)) * here.stiffness;
      sum_.resize(r, 2 * r);
      subtract(here.stiffness, d + kNodes[static_cast<std::size_t>(i)] * h * v);
      if (here.rate.isDiagonal(0.0))
        sum_.matrix() -= here.rate.diagonal().asDiagonal() * v;
      else
        subtract(here.rate, v);
      right_.middleRows(i * r, r) = sum_.matrix();
    }
    matrix_.diagonal().array() += 1.0;
    factor_.compute(matrix_);
    factor_.solve_in_place(right_);
    d += h * v;
    for (int i = 0; i < kStages; ++i) {
      const double weight = kWeights[static_cast<std::size_t>(i)];
      const double left = 1.0 - kNodes[static_cast<std::size_t>(i)];
      // b^T A = b (1 - c) for Gauss's nodes.
      d += (h * h * weight * left) * right_.middleRows(i * r, r);
      v += (h * weight) * right_.middleRows(i * r, r);
    }
  }

 private:
  // sum_ -= square columns.
  template <class Columns>
  void subtract(const Eigen::MatrixXd& square, const Columns& columns) {
    square_.matrix() = square;
    columns_.matrix() = columns;
    sum_.subtract_product(square_, columns_);
  }

  Eigen::MatrixXd matrix_, right_;
  DenseLu factor_;
  PaddedMatrix square_, columns_, sum_;
};

}  // namespace

int floquet_steps(Eigen::Index harmonics) {
  return static_cast<int>(std::max<Eigen::Index>(32, 4 * harmonics));
}

Eigen::MatrixXd monodromy(const VibratingSystem& system, const FourierSeries& motion, double omega,
                          int steps) {
  const Eigen::Index r = system.size();
  Eigen::MatrixXd d = Eigen::MatrixXd::Identity(r, 2 * r), v = Eigen::MatrixXd::Zero(r, 2 * r);
  v.rightCols(r).setIdentity();
  AlongMotion motion_at(system, motion, omega);
  GaussStep step(r);
  std::array<Coefficients, kStages> at;
  const double h = 2.0 * std::numbers::pi / static_cast<double>(steps);
  for (int n = 0; n < steps; ++n) {
    for (std::size_t i = 0; i < at.size(); ++i) motion_at.at((n + kNodes[i]) * h, at[i]);
    step.take(at, h, d, v);
  }
  Eigen::MatrixXd result(2 * r, 2 * r);
  result << d, v;
  return result;
}

Eigen::VectorXcd floquet_multipliers(const VibratingSystem& system, const FourierSeries& motion,
                                     double omega, int steps) {
  Eigen::MatrixXd matrix = monodromy(system, motion, omega, steps);
  // In units in which the stiff coordinates' velocities are as large as their displacements.
  const Eigen::Index r = system.size();
  const Eigen::VectorXd speed = (system.potential.lambda().cwiseSqrt() / omega).cwiseMax(1e-3);
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
