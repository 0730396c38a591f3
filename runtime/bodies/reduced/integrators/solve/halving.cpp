#include "runtime/bodies/reduced/integrators/solve/halving.h"

#include <cmath>
#include <exception>
#include <utility>
#include <vector>

namespace tremolo {
namespace {

class Halving final : public Integrator {
 public:
  Halving(IntegratorMaker make, Model::Pointer model, const IntegratorOptions& options,
          std::unique_ptr<Integrator> whole)
      : make_(make), model_(std::move(model)), options_(options) {
    levels_.reserve(static_cast<std::size_t>(options.halvings) + 1);
    levels_.push_back({std::move(whole), {}, {}, {}});
  }

  StepReport step(State& state, const StepLoad& load) noexcept override {
    const StepReport report = levels_.front().integrator->step(state, load);
    if (report.converged) return report;
    // A state or a load that is not finite does not become finite in parts.
    if (!state.q.allFinite() || !state.p.allFinite() || !load.start.allFinite() ||
        !load.average.allFinite() || !load.end.allFinite())
      return report;
    try {
      return in_parts(state, load, 1, report);
    } catch (const std::exception&) {  // no memory for a level: the failure remains
      return report;
    }
  }

  void reset() override {
    for (Level& level : levels_) level.integrator->reset();
  }
  void carry(StateStream& stream) override {
    std::size_t count = levels_.size();
    stream(count);
    stream.require(count >= 1 && count <= static_cast<std::size_t>(options_.halvings) + 1);
    if (!stream.good()) return;
    while (levels_.size() > count) levels_.pop_back();
    for (std::size_t depth = 0; depth < count && stream.good(); ++depth) {
      stream.require(make_level(depth));
      if (stream.good()) levels_[depth].integrator->carry(stream);
    }
  }
  void follow(const Integrator& before) override {
    if (const auto* other = dynamic_cast<const Halving*>(&before))
      levels_.front().integrator->follow(*other->levels_.front().integrator);
  }
  std::string_view name() const override { return levels_.front().integrator->name(); }
  std::optional<Split> split() const override { return levels_.front().integrator->split(); }
  std::optional<double> known_potential(const Eigen::VectorXd& q) const override {
    return levels_.front().integrator->known_potential(q);
  }
  void synchronized_momentum(const State& state, Eigen::VectorXd& p) const override {
    levels_.front().integrator->synchronized_momentum(state, p);
  }

 private:
  struct Level {
    std::unique_ptr<Integrator> integrator;
    State start;             // before the two parts of this level
    Eigen::VectorXd middle;  // q between them
    StepLoad part;           // the load of one of them
  };

  bool make_level(std::size_t depth) {
    if (depth < levels_.size()) return true;
    if (depth > static_cast<std::size_t>(options_.halvings)) return false;
    IntegratorOptions options = options_;
    options.step = std::ldexp(options_.step, -static_cast<int>(depth));
    if (const std::optional<Split> split = this->split()) {
      options.split.rule = SplitRule::kCount;
      options.split.count = static_cast<int>(split->low);
    }
    Result<std::unique_ptr<Integrator>> made = make_(model_, options);
    if (!made) return false;
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(model_->modes());
    levels_.push_back({std::move(*made), {zero, zero}, zero, make_step_load(model_->modes())});
    return true;
  }

  // Takes the step that failed with `failure` as two of the given depth. On failure the state is as
  // before.
  StepReport in_parts(State& state, const StepLoad& load, std::size_t depth,
                      const StepReport& failure) {
    if (!make_level(depth)) return failure;
    Level& level = levels_[depth];
    level.start = state;
    level.middle = state.q;
    StepReport sum = failure;
    sum.converged = true;
    sum.dissipated = 0.0;  // the energy taken in the failed step was returned
    sum.parts = 0;
    double work = 0.0;
    for (const double begin : {0.0, 0.5}) {
      restrict_load(load, begin, begin + 0.5, level.part);
      StepReport part = level.integrator->step(state, level.part);
      if (!part.converged) part = in_parts(state, level.part, depth + 1, part);
      sum.iterations += part.iterations;
      sum.residual = part.residual;
      if (!part.converged) {
        state = level.start;
        sum.converged = false;
        return sum;
      }
      sum.parts += part.parts;
      sum.dissipated += part.dissipated;
      work += part.extra_work + level.part.average.dot(state.q - level.middle);
      level.middle = state.q;
    }
    sum.extra_work = work - load.average.dot(state.q - level.start.q);
    return sum;
  }

  IntegratorMaker make_;
  Model::Pointer model_;
  IntegratorOptions options_;
  std::vector<Level> levels_;
};

}  // namespace

Result<std::unique_ptr<Integrator>> make_halving(IntegratorMaker make, Model::Pointer model,
                                                 const IntegratorOptions& options) {
  Result<std::unique_ptr<Integrator>> whole = make(model, options);
  if (!whole) return whole.error();
  return std::unique_ptr<Integrator>(
      std::make_unique<Halving>(make, std::move(model), options, std::move(*whole)));
}

}  // namespace tremolo
