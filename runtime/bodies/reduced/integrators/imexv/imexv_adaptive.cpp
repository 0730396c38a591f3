// `imexv` (imexv.cpp) with a split that follows the motion.
//
// Deformation stiffens a solid: the explicit half is stable only while h^2 lambda_max(K_ll(q)) < 4,
// K_ll the low rows' block of the tangent at the present q, and a split made for K(0) may leave
// that. Whether a block obeys lambda_max(K_ll) < b is answered exactly by one Cholesky
// factorisation of b I - K_ll: it runs through iff the block obeys, and where it stops at pivot j
// the leading j coordinates are the largest leading block that does. K(q) costs nothing beside
// R(q), which every step evaluates there anyway.
//
//   - before each step: b = (2 leave/h)^2, leave = (1 + safety)/2. The coordinates from the pivot
//     that fails on become implicit at once.
//   - the block with one coordinate more has obeyed the stricter b = (2 safety/h)^2 for as long as
//     one period of the lowest mode (100 steps at least, 10 000 at most): that coordinate becomes
//     explicit again.
//
// The bound is necessary, not sufficient: V couples low and high rows, `imexv` is symplectic only
// where it does not, and strong coupling can add energy while every block obeys. Therefore the
// balance is checked too. If after a step H exceeds the energy that was there and was put in by a
// tenth, the step is repeated with half of the low coordinates, the others are implicit until
// reset(), and the check starts again from there. Without low coordinates the step is the midpoint
// rule.
//
// Each step is one of `imexv` with the present split: its order, damping and dissipation. A change
// of split shifts the level about which the energy oscillates by a part of that oscillation; this
// is why coordinates return late.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "runtime/bodies/reduced/integrators/imexv/imexv_step.h"

namespace tremolo {
namespace {

using Eigen::Index;

constexpr double kShortestWait = 100.0;  // steps before a coordinate may become explicit again
constexpr double kLongestWait = 10000.0;
// Of the highest balance: H may exceed the balance by this fraction.
constexpr double kExcess = 0.1;

// The size of the largest leading block of `matrix`, up to `count`, with b I - block positive
// definite. factor: r x r scratch.
Index leading_below(const Eigen::MatrixXd& matrix, Index count, double b, Eigen::MatrixXd& factor) {
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

class ImexvAdaptive final : public ImexvStep {
 public:
  ImexvAdaptive(Model::Pointer model, const IntegratorOptions& options, Split split)
      : ImexvStep("imexv-adaptive", std::move(model), options, split,
                  kWantEnergy | kWantForce | kWantTangent, kUseTangent),
        most_low_(model_->modes()),
        factor_(Eigen::MatrixXd::Zero(model_->modes(), model_->modes())),
        z1_(z0_) {
    const double safety = options.split.safety, leave = 0.5 * (1.0 + safety);
    leave_bound_ = 4.0 * leave * leave / (h_ * h_);
    return_bound_ = 4.0 * safety * safety / (h_ * h_);
    const double period = 2.0 * std::numbers::pi / std::sqrt(model_->lambda()[0]);
    wait_ = static_cast<int>(std::clamp(std::ceil(period / h_), kShortestWait, kLongestWait));
    const auto scratch = std::make_shared<HighScratch>(model_->potential());
    const Index r = model_->modes();
    high_.reserve(static_cast<std::size_t>(r) + 1);
    for (Index low = 0; low <= r; ++low)
      high_.emplace_back(*model_, Split{low, r - low}, options, HighDamping::kMeanVelocity,
                         SolveNorm::kRelative, scratch);
  }

  StepReport step(State& state, const StepLoad& load) noexcept override {
    z0_ = state;
    if (!watching_ || z1_.q != state.q || z1_.p != state.p) begin_watch(state);
    const Index low_before = low_, most_low_before = most_low_;
    const int patience_before = patience_;
    const Balance balance_before = balance_;
    choose(state.q);
    StepReport report = split_step(high(), state, load);
    while (report.converged && low_ > 0 && exceeds(state, load, gain_of(report, state, load))) {
      const int iterations = report.iterations;
      state = z0_;
      low_ /= 2;
      most_low_ = low_;
      begin_watch(state);
      report = split_step(high(), state, load);
      report.iterations += iterations;
    }
    if (!report.converged) {
      state = z0_;
      low_ = low_before;
      most_low_ = most_low_before;
      patience_ = patience_before;
      balance_ = balance_before;
      return report;
    }
    balance_.now += gain_of(report, state, load);
    balance_.highest = std::max(balance_.highest, balance_.now);
    z1_ = state;
    return report;
  }

  void reset() override {
    patience_ = 0;
    most_low_ = model_->modes();
    watching_ = false;
  }

  void follow(const Integrator& before) override {
    const auto* other = dynamic_cast<const ImexvAdaptive*>(&before);
    if (other == nullptr) return;
    low_ = other->low_;
    most_low_ = other->most_low_;
    patience_ = other->patience_;
  }

  void carry(StateStream& stream) override {
    Index low = low_, most_low = most_low_;
    stream(V_, low, most_low, patience_, watching_, balance_.now, balance_.highest, z1_);
    stream.require(low >= 0 && low <= model_->modes() && most_low >= 0 &&
                   most_low <= model_->modes());
    if (!stream.good()) return;
    low_ = low;
    most_low_ = most_low;
  }

 private:
  // now: H at the start of the check, plus work, less dissipation, J. highest: since that start.
  struct Balance {
    double now = 0.0;
    double highest = 0.0;
  };

  HighRows& high() { return high_[low_]; }

  void choose(const Eigen::VectorXd& q) {
    const Eigen::MatrixXd& K = V_.tangent(q);
    const Index allowed = leading_below(K, low_, leave_bound_, factor_);
    if (allowed < low_) {
      low_ = allowed;
      patience_ = 0;
      return;
    }
    if (low_ >= most_low_) return;
    const bool could = leading_below(K, low_ + 1, return_bound_, factor_) == low_ + 1;
    patience_ = could ? patience_ + 1 : 0;
    if (patience_ < wait_) return;
    ++low_;
    patience_ = 0;
  }

  double energy(const State& z) { return 0.5 * z.p.squaredNorm() + V_.energy(z.q); }

  void begin_watch(const State& state) {
    watching_ = true;
    balance_.now = balance_.highest = energy(state);
  }

  // The change of H that the step should have caused, J.
  double gain_of(const StepReport& report, const State& state, const StepLoad& load) const {
    return load.average.dot(state.q - z0_.q) - report.dissipated;
  }

  bool exceeds(const State& state, const StepLoad& load, double gain) {
    // A kick adds its energy before the motion along which it does work.
    const double kick =
        load.active ? h_ * h_ * std::max(load.start.squaredNorm(), load.end.squaredNorm()) : 0.0;
    return energy(state) > balance_.now + gain + kExcess * balance_.highest + kick;
  }

  double leave_bound_ = 0.0;  // of lambda_max(K_ll), (rad/s)^2
  double return_bound_ = 0.0;
  int wait_ = 0;      // steps
  int patience_ = 0;  // steps for which the next coordinate could have become explicit
  Index most_low_;    // number of coordinates that may become explicit
  bool watching_ = false;
  Balance balance_;
  Eigen::MatrixXd factor_;
  std::vector<HighRows> high_;  // one for each split
  State z1_;                    // of the last step
};

}  // namespace

MadeIntegrator make_imexv_adaptive(Model::Pointer model, const IntegratorOptions& options) {
  return make_split_method<ImexvAdaptive>(std::move(model), options);
}

}  // namespace tremolo
