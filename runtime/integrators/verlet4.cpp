#include "runtime/integrators/verlet4.h"

#include <array>
#include <cmath>
#include <utility>

#include "runtime/integrators/solve/damping.h"
#include "runtime/integrators/solve/force_cache.h"

namespace tremolo {
namespace {

constexpr double kB1 = 0.0829844064174052;
constexpr double kB2 = 0.396309801498368;
constexpr double kB3 = -0.0390563049223486;
constexpr double kB4 = 1.0 - 2.0 * (kB1 + kB2 + kB3);
constexpr double kA1 = 0.245298957184271;
constexpr double kA2 = 0.604872665711080;
constexpr double kA3 = 0.5 - (kA1 + kA2);

constexpr std::array kDrifts = {kA1, kA2, kA3};  // in steps; then backwards

// After each kick but the last comes the drift of that number in kDrifts.
struct Kick {
  double weight;
  double node;  // in steps
  int drift;
};
constexpr std::array kKicks = {Kick{kB1, 0.0, 0}, Kick{kB2, kA1, 1},       Kick{kB3, kA1 + kA2, 2},
                               Kick{kB4, 0.5, 2}, Kick{kB3, 0.5 + kA3, 1}, Kick{kB2, 1.0 - kA1, 0},
                               Kick{kB1, 1.0, -1}};

// The exact flow of q' = p, p' = -D p over one drift.
struct Drift {
  Eigen::VectorXd reach;  // (1 - e^{-D s})/D, s
  Eigen::VectorXd decay;  // e^{-D s}
};

Drift make_drift(const Eigen::VectorXd& rates, double time) {
  return {rates.unaryExpr([time](double rate) {
            const double x = rate * time;  // zero also where a tiny rate underflows
            return x == 0.0 ? time : time * (-std::expm1(-x) / x);
          }),
          (-time * rates.array()).exp().matrix()};
}

class Verlet4 final : public Integrator {
 public:
  Verlet4(Model::Pointer model, const IntegratorOptions& options)
      : model_(std::move(model)),
        step_(options.step),
        damped_(options.alpha > 0.0 || options.beta > 0.0),
        forces_(model_->potential()) {
    const Eigen::VectorXd rates = damping_rates(model_->lambda(), options.alpha, options.beta);
    for (std::size_t i = 0; i < kDrifts.size(); ++i)
      drifts_[i] = make_drift(rates, kDrifts[i] * step_);
    start_ = {rates, rates};
    load_ = impulse_ = rates;
  }

  StepReport step(State& state, const StepLoad& load) noexcept override {
    StepReport report;
    double work = 0.0;
    start_ = state;
    for (const auto& [weight, node, drift] : kKicks) {
      const double share = weight * step_;
      load_at(load, node, load_);
      impulse_ = share * (load_ - forces_.force(state.q));
      work += share * load_.dot(state.p + 0.5 * impulse_);
      state.p += impulse_;
      if (drift < 0) break;
      const auto& [reach, decay] = drifts_[static_cast<std::size_t>(drift)];
      state.q.array() += reach.array() * state.p.array();
      if (damped_) report.dissipated += decay_momentum(decay, state.p);
    }
    report.extra_work = work - load.average.dot(state.q - start_.q);
    report.converged = state.q.allFinite() && state.p.allFinite();
    if (!report.converged) state = start_;
    return report;
  }

  std::string_view name() const override { return "verlet4"; }
  std::optional<double> known_potential(const Eigen::VectorXd& q) const override {
    return forces_.known_energy(q);
  }

 private:
  Model::Pointer model_;
  double step_;
  bool damped_;
  std::array<Drift, kDrifts.size()> drifts_;
  ForceCache forces_;
  State start_;
  Eigen::VectorXd load_;
  Eigen::VectorXd impulse_;
};

}  // namespace

std::unique_ptr<Integrator> make_verlet4(Model::Pointer model, const IntegratorOptions& options) {
  return std::make_unique<Verlet4>(std::move(model), options);
}

}  // namespace tremolo
