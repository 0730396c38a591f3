// A step from q0, p0 to q0 + d, p1 solves, with F the mean force below and a symmetric N > 0,
//
//   2 N (N d/h - p0)/h + F(q0, q0 + d) = 0,        p1 = p0 + 2 (N d/h - p0),
//
// of which d . (the first) is the change of the energy, where F . d is that of V. The mean of grad
// V on the segment is exact for a quartic V with two points of Gauss. For another V a vector along
// d is added, as in Gonzalez's discrete gradient, so that F . d = V(q0 + d) - V(q0) holds for any
// V. The vector is of fourth order in h, so that it does not change the order of either method. avf
// has N = I; ep4 has N(h^2 K/4) of the engine, with K in the middle of the step, found by
// repetition from that of avf. Both are symmetric in time.
#include "runtime/apps/python/module/own_preserving.h"

#include <cmath>
#include <limits>

#include <Eigen/Core>
#include <Eigen/LU>

#include "runtime/bodies/reduced/integrators/solve/inertia_filter.h"
#include "runtime/math/dense/decompositions.h"

namespace tremolo::python {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kShortenings = 10;  // of a correction that does not help
constexpr int kMostFilters = 10;  // of a step: each is nearer to that of its own middle

class Preserving final : public NodalIntegrator {
 public:
  Preserving(bool fourth, const OwnPotential& potential, const NodalOptions& options)
      : fourth_(fourth), potential_(potential), options_(options) {}

  std::string_view name() const override { return fourth_ ? "ep4" : "avf"; }
  void reset() override {}

  NodalReport step(NodalState& state) override {
    const Eigen::Index r = potential_.coordinates();
    const double h = options_.step;
    q_ = state.x.head(r);
    p_ = state.v.head(r);
    start_ = potential_.value(q_);
    NodalReport report;
    VectorXd d = h * p_;
    report.made = solve(MatrixXd::Identity(r, r), d, report);
    MatrixXd n = MatrixXd::Identity(r, r);
    for (int k = 0; report.made && fourth_ && k < kMostFilters; ++k) {
      n = filter(q_ + 0.5 * d);
      const int before = report.iterations;
      report.made = solve(n, d, report);
      if (report.iterations == before) break;  // N is already that of the middle
    }
    if (!report.made) return report;
    state.x.head(r) = q_ + d;
    state.v.head(r) += 2.0 * (n * d / h - p_);
    state.time += h;
    return report;
  }

 private:
  MatrixXd filter(const VectorXd& middle) const {
    const SymmetricEigen modes = symmetric_eigen(potential_.tangent(middle));
    const double factor = 0.25 * options_.step * options_.step;
    const VectorXd weights = modes.values.unaryExpr(
        [factor](double k) { return filter_value(kRobustShape, factor * k); });
    return modes.vectors * weights.asDiagonal() * modes.vectors.transpose();
  }

  VectorXd mean_force(const VectorXd& d) const {
    static const double kOff = 0.5 / std::sqrt(3.0);
    VectorXd f =
        0.5 * (potential_.slope(q_ + (0.5 - kOff) * d) + potential_.slope(q_ + (0.5 + kOff) * d));
    const double end = potential_.value(q_ + d), square = d.squaredNorm();
    const double defect = end - start_ - f.dot(d);
    // Below this the defect is rounding, which would grow by 1/|d|.
    const double rounding =
        8.0 * std::numeric_limits<double>::epsilon() * (std::abs(start_) + std::abs(end));
    if (square > 0.0 && std::abs(defect) > rounding) f += (defect / square) * d;
    return f;
  }
  VectorXd residual(const MatrixXd& n, const VectorXd& d) const {
    const double h = options_.step;
    return 2.0 / h * (n * (n * d / h - p_)) + mean_force(d);
  }

  // Newton's method with K in the middle, which is computed again where the last one does not
  // serve.
  bool solve(const MatrixXd& n, VectorXd& d, NodalReport& report) const {
    const double h = options_.step;
    const MatrixXd inertia = 2.0 / (h * h) * n * n;
    VectorXd r = residual(n, d);
    Eigen::PartialPivLU<MatrixXd> factor;
    bool fresh = false, known = false;
    for (int k = 0; k < options_.max_iterations; ++k) {
      report.residual = r.norm();
      if (!std::isfinite(report.residual)) return false;
      if (report.residual <= options_.tolerance * potential_.force_size()) return true;
      if (!known) {
        const MatrixXd matrix = inertia + 0.5 * potential_.tangent(q_ + 0.5 * d);
        if (!matrix.allFinite()) return false;
        factor.compute(matrix);
        known = fresh = true;
      }
      ++report.iterations;
      const VectorXd move = factor.solve(r);
      double length = 1.0;
      VectorXd next = d - move, left = residual(n, next);
      for (int s = 0; s < kShortenings && !(left.norm() < report.residual); ++s) {
        length *= 0.5;
        next = d - length * move;
        left = residual(n, next);
      }
      // A matrix of this very step that does not help is not computed again.
      if (!(left.norm() < report.residual) && fresh) return false;
      known = left.norm() < 0.1 * report.residual;
      fresh = false;
      if (!(left.norm() < report.residual)) continue;
      d = next;
      r = left;
    }
    return false;
  }

  bool fourth_;
  const OwnPotential& potential_;
  NodalOptions options_;
  VectorXd q_, p_;      // at the start of the step
  double start_ = 0.0;  // V there
};

}  // namespace

std::unique_ptr<NodalIntegrator> make_preserving(std::string_view name,
                                                 const OwnPotential& potential,
                                                 const NodalOptions& options) {
  if (name != "avf" && name != "ep4") return nullptr;
  return std::make_unique<Preserving>(name == "ep4", potential, options);
}

}  // namespace tremolo::python
