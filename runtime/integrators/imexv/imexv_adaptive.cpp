#include "runtime/integrators/imexv/imexv_adaptive.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "runtime/integrators/imexv/high_rows.h"
#include "runtime/integrators/solve/damping.h"
#include "runtime/integrators/solve/force_cache.h"

namespace tremolo {
namespace {

using Eigen::Index;

constexpr double kShortestWait = 100.0;  // steps before a coordinate may come back
constexpr double kLongestWait = 10000.0;
constexpr double kExcess = 0.1;  // of the highest balance: by so much H may exceed it

// The size of the largest leading block of `matrix`, up to `count`, with b I - block positive
// definite. factor: r x r scratch.
Index obedient(const Eigen::MatrixXd& matrix, Index count, double b, Eigen::MatrixXd& factor) {
  for (Index j = 0; j < count; ++j) {
    for (Index i = 0; i < j; ++i)
      factor(i, j) =
          (-matrix(i, j) - factor.col(i).head(i).dot(factor.col(j).head(i))) / factor(i, i);
    const double pivot = b - matrix(j, j) - factor.col(j).head(j).squaredNorm();
    if (!(pivot > 0.0)) return j;
    factor(j, j) = std::sqrt(pivot);
  }
  return count;
}

class ImexvAdaptive final : public Integrator {
 public:
  ImexvAdaptive(Model::Pointer model, const IntegratorOptions& options, Split split)
      : model_(std::move(model)),
        options_(options),
        low_(split.low),
        kick_(damping_rates(model_->lambda(), options.alpha, options.beta), options.step),
        most_low_(model_->modes()),
        forces_(model_->potential(), true),
        factor_(Eigen::MatrixXd::Zero(model_->modes(), model_->modes())),
        start_{model_->lambda(), model_->lambda()},
        end_(start_) {
    const double h = options.step;
    const double leave = 0.5 * (1.0 + options.split.safety);
    leave_bound_ = 4.0 * leave * leave / (h * h);
    return_bound_ = 4.0 * options.split.safety * options.split.safety / (h * h);
    const double period = 2.0 * std::numbers::pi / std::sqrt(model_->lambda()[0]);
    wait_ = static_cast<int>(std::clamp(std::ceil(period / h), kShortestWait, kLongestWait));
    const auto scratch = std::make_shared<HighScratch>(model_->potential());
    const Index r = model_->modes();
    high_.reserve(static_cast<std::size_t>(r) + 1);
    for (Index low = 0; low <= r; ++low)
      high_.emplace_back(*model_, Split{low, r - low}, options, HighDamping::kMeanVelocity,
                         SolveNorm::kRelative, scratch);
  }

  StepReport step(State& state, const StepLoad& load) noexcept override {
    start_ = state;
    if (!watching_ || end_.q != state.q || end_.p != state.p) begin_watch(state);
    const Index low_before = low_, most_low_before = most_low_;
    const int patience_before = patience_;
    const double balance_before = balance_, highest_before = highest_;
    choose(state.q);
    StepReport report = split_step(state, load);
    while (report.converged && low_ > 0 && exceeds(state, load, gain_of(report, state, load))) {
      const int iterations = report.iterations;
      state = start_;
      low_ /= 2;
      most_low_ = low_;
      begin_watch(state);
      report = split_step(state, load);
      report.iterations += iterations;
    }
    if (!report.converged) {
      state = start_;
      low_ = low_before;
      most_low_ = most_low_before;
      patience_ = patience_before;
      balance_ = balance_before;
      highest_ = highest_before;
      return report;
    }
    balance_ += gain_of(report, state, load);
    highest_ = std::max(highest_, balance_);
    end_ = state;
    return report;
  }

  void reset() override {
    patience_ = 0;
    most_low_ = model_->modes();
    watching_ = false;
  }
  std::string_view name() const override { return "imexv-adaptive"; }
  std::optional<double> known_potential(const Eigen::VectorXd& q) const override {
    return forces_.known_energy(q);
  }
  std::optional<Split> split() const override { return Split{low_, model_->modes() - low_}; }

 private:
  // A step of imexv with the present split.
  StepReport split_step(State& state, const StepLoad& load) {
    double dissipated = kick_low(state, load.start);
    state.q.head(low_) += options_.step * state.p.head(low_);
    StepReport report =
        high_[static_cast<std::size_t>(low_)].advance(start_.q, state, load.average);
    if (!report.converged) return report;
    dissipated += kick_low(state, load.end);
    report.dissipated += dissipated;
    report.converged = state.q.allFinite() && state.p.allFinite();
    return report;
  }

  void choose(const Eigen::VectorXd& q) {
    const Eigen::MatrixXd& tangent = forces_.tangent(q);
    const Index allowed = obedient(tangent, low_, leave_bound_, factor_);
    if (allowed < low_) {
      low_ = allowed;
      patience_ = 0;
      return;
    }
    if (low_ >= most_low_) return;
    const bool could = obedient(tangent, low_ + 1, return_bound_, factor_) == low_ + 1;
    patience_ = could ? patience_ + 1 : 0;
    if (patience_ < wait_) return;
    ++low_;
    patience_ = 0;
  }

  double energy(const State& state) {
    return 0.5 * state.p.squaredNorm() + forces_.energy(state.q);
  }

  void begin_watch(const State& state) {
    watching_ = true;
    balance_ = highest_ = energy(state);
  }

  // What the step should have added to H.
  double gain_of(const StepReport& report, const State& state, const StepLoad& load) const {
    return load.average.dot(state.q - start_.q) - report.dissipated;
  }

  bool exceeds(const State& state, const StepLoad& load, double gain) {
    const double h = options_.step;
    // A kick gives its energy before the motion that it does its work on.
    const double kick =
        load.active ? h * h * std::max(load.start.squaredNorm(), load.end.squaredNorm()) : 0.0;
    return energy(state) > balance_ + gain + kExcess * highest_ + kick;
  }

  // Returns the energy that damping took.
  double kick_low(State& state, const Eigen::VectorXd& load) {
    return kick_((load - forces_.force(state.q)).head(low_), state.p);
  }

  Model::Pointer model_;
  IntegratorOptions options_;
  Index low_;
  DampedKick kick_;
  double leave_bound_ = 0.0;  // of lambda_max(K_ll), (rad/s)^2
  double return_bound_ = 0.0;
  int wait_ = 0;      // steps
  int patience_ = 0;  // steps for which the next coordinate could have come back
  Index most_low_;    // how many may come back
  bool watching_ = false;
  double balance_ = 0.0;  // H at the start of the watch, plus work, less dissipation
  double highest_ = 0.0;
  ForceCache forces_;
  Eigen::MatrixXd factor_;
  std::vector<HighRows> high_;  // one for each split
  State start_;
  State end_;  // of the last step
};

}  // namespace

Result<std::unique_ptr<Integrator>> make_imexv_adaptive(Model::Pointer model,
                                                        const IntegratorOptions& options) {
  const Result<Split> split = choose_split(model->lambda(), options.step, options.split);
  if (!split) return split.error();
  return std::unique_ptr<Integrator>(
      std::make_unique<ImexvAdaptive>(std::move(model), options, *split));
}

}  // namespace tremolo
