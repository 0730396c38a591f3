// The implicit methods as equations for x1 (runtime/step/implicit_solve.h), d = x1 - x0:
//
//   implicit-euler   M (d - h v0)/h^2 = f(x1, d/h),                      v1 = d/h
//   implicit-euler-linear: its first Newton step from x1 = x0
//   midpoint         2 M (d - h v0)/h^2 = f(x0 + d/2, d/h),              v1 = 2 d/h - v0
//   energy           2 M (d - h v0)/h^2 = step_force(x0, x1),            v1 = 2 d/h - v0
//   newmark          4 M (d - h v0 - h^2/4 a0)/h^2 = f(x1, v1),          v1 = 2 d/h - v0
//   bdf2             9/4 M (x1 - X - 2/3 h V)/h^2 = f(x1, v1),           v1 = 3/(2h) (x1 - X)
//                    X = (4 x0 - x-1)/3, V = (4 v0 - v-1)/3
#include <algorithm>
#include <cmath>

#include "runtime/step/halved_step.h"
#include "runtime/step/implicit_solve.h"

namespace tremolo {
namespace {

class ImplicitMethod : public HalvedIntegrator {
 public:
  ImplicitMethod(const NodalSystem& system, const NodalOptions& options,
                 std::unique_ptr<ImplicitSolve> solve)
      : HalvedIntegrator(system, options), solve_(std::move(solve)) {
    x1_ = v1_ = x_hat_ = v_hat_ = Eigen::VectorXd::Zero(3 * system.mass().size());
  }
  void carry(StateStream& stream) override {
    stream(gained_, largest_);
    if (stream.reads()) stream.require(std::isfinite(gained_) && std::isfinite(largest_));
    solve_->carry(stream);
  }

 protected:
  // A vector of the step before, which has no size before the first step.
  void carry_vector(StateStream& stream, Eigen::VectorXd& vector) {
    stream.sized(vector);
    stream.require(vector.size() == 0 || vector.size() == x1_.size());
    if (stream.reads()) stream.require(vector.allFinite());
  }
  // The first guess, motion by inertia, with fixed nodes at their ends.
  void guess(const NodalState& state, double h) {
    x1_ = state.x + h * state.v;
    put_held_nodes(system(), state.time + h, h, state.x, x1_, v1_);
  }
  // Solves the midpoint rule from the guess, or with `energy` the method of this name; sets x1_ and
  // v1_. False: the equation was not solved.
  bool solve_middle(const NodalState& state, double h, bool energy, NodalReport& report) {
    x_hat_ = state.x + h * state.v;
    v_hat_.setZero();
    const ImplicitEquation equation{.mu = 2.0 / (h * h),
                                    .theta = 0.5,
                                    .kappa = 1.0 / h,
                                    .x0 = &state.x,
                                    .x_hat = &x_hat_,
                                    .v_hat = &v_hat_,
                                    .h = energy ? h : 0.0};
    if (!solve_->solve(equation, x1_, false, report)) return false;
    v1_ = (2.0 / h) * (x1_ - state.x) - state.v;
    return true;
  }
  // At fixed nodes sets v_hat so that the velocity at the end is that of their displacement, times
  // `part` (1/s).
  void hold_velocities(const NodalState& state, double part) {
    for (Eigen::Index i = 0; i < system().mass().size(); ++i)
      if (system().held()[i] != 0)
        v_hat_.segment<3>(3 * i) = part * (x1_.segment<3>(3 * i) - state.x.segment<3>(3 * i));
  }
  // Ends the step with v1 set by the method and fixed nodes set. share: same as for
  // NodalContact::keep().
  void finish(NodalState& state, double h, double share, NodalReport& report) {
    put_held_nodes(system(), state.time + h, h, state.x, x1_, v1_);
    take_step(state, h, share, x1_, v1_, report);
  }
  // The same for a method that may add energy. False: the step needs the rule of `energy`, and that
  // fails.
  bool finish_guarded(NodalState& state, double h, double share, NodalReport& report) {
    if (!options().guard || !options().account) {
      finish(state, h, share, report);
      return true;
    }
    put_held_nodes(system(), state.time + h, h, state.x, x1_, v1_);
    NodalReport trial = report;
    ledger().begin(state);
    state.x.swap(x1_);
    state.v.swap(v1_);
    ledger().end(state, h, share, trial);
    const double gain = trial.numerical - report.numerical;
    largest_ = std::max(largest_, ledger().turnover());
    if (gain <= 0.0 || gained_ + gain <= kMostGain * largest_) {
      gained_ = std::max(0.0, gained_ + gain);
      report = trial;
      if (NodalContact* contact = system().contact()) contact->keep(state.x, h, share);
      state.time += h;
      return true;
    }
    state.x.swap(x1_);
    state.v.swap(v1_);
    ++report.guarded;
    reset();
    return again(state, h, report);
  }
  // Replaces a step that would have added energy.
  virtual bool again(NodalState& state, double h, NodalReport& report) {
    return balanced(state, h, report);
  }
  // The rule of `energy`, from the guess x1_.
  bool balanced(NodalState& state, double h, NodalReport& report) {
    if (!solve_middle(state, h, true, report)) return false;
    put_held_nodes(system(), state.time + h, h, state.x, x1_, v1_);
    if (NodalContact* contact = system().contact()) contact->keep(x1_, h, 1.0);
    ledger().begin(state);
    const double held = held_work(system(), solve_->force(), state.x, x1_);
    state.x.swap(x1_);
    state.v.swap(v1_);
    state.time += h;
    ledger().end(state, solve_->work(), held, report);
    return true;
  }

  std::unique_ptr<ImplicitSolve> solve_;
  Eigen::VectorXd x1_, v1_, x_hat_, v_hat_;

 private:
  // Limit of the energy that a method may add, since it last took as much, relative to the largest
  // energy.
  static constexpr double kMostGain = 0.01;

  double gained_ = 0.0, largest_ = 0.0;  // J
};

class ImplicitEuler : public ImplicitMethod {
 public:
  ImplicitEuler(const NodalSystem& system, const NodalOptions& options,
                std::unique_ptr<ImplicitSolve> solve, bool once)
      : ImplicitMethod(system, options, std::move(solve)), once_(once) {}
  std::string_view name() const override {
    return once_ ? "implicit-euler-linear" : "implicit-euler";
  }

 protected:
  bool advance(NodalState& state, double h, NodalReport& report) override {
    x_hat_ = state.x + h * state.v;
    v_hat_.setZero();
    guess(state, h);
    // Baraff and Witkin linearise at the start of the step.
    if (once_) {
      x1_ = state.x;
      put_held_nodes(system(), state.time + h, h, state.x, x1_, v1_);
    }
    if (!solve(state, h, once_, report)) return false;
    if (once_) return finish_guarded(state, h, 1.0, report);
    finish(state, h, 1.0, report);
    return true;
  }
  // The same step by Newton's method.
  bool again(NodalState& state, double h, NodalReport& report) override {
    if (!solve(state, h, false, report)) return false;
    finish(state, h, 1.0, report);
    return true;
  }

 private:
  bool solve(const NodalState& state, double h, bool once, NodalReport& report) {
    const ImplicitEquation equation{.mu = 1.0 / (h * h),
                                    .theta = 1.0,
                                    .kappa = 1.0 / h,
                                    .x0 = &state.x,
                                    .x_hat = &x_hat_,
                                    .v_hat = &v_hat_,
                                    .minimum = true};
    if (!solve_->solve(equation, x1_, once, report)) return false;
    v1_ = (x1_ - state.x) / h;
    return true;
  }

  bool once_;
};

// The methods midpoint and energy.
class Middle : public ImplicitMethod {
 public:
  Middle(const NodalSystem& system, const NodalOptions& options,
         std::unique_ptr<ImplicitSolve> solve, bool energy)
      : ImplicitMethod(system, options, std::move(solve)), energy_(energy) {}
  std::string_view name() const override { return energy_ ? "energy" : "midpoint"; }

 protected:
  bool advance(NodalState& state, double h, NodalReport& report) override {
    guess(state, h);
    if (energy_) return balanced(state, h, report);
    return solve_middle(state, h, false, report) && finish_guarded(state, h, 1.0, report);
  }

 private:
  bool energy_;
};

class Newmark : public ImplicitMethod {
 public:
  using ImplicitMethod::ImplicitMethod;
  std::string_view name() const override { return "newmark"; }
  void reset() override { known_ = false; }
  void carry(StateStream& stream) override {
    ImplicitMethod::carry(stream);
    stream(known_);
    carry_vector(stream, a_);
    stream.require(!known_ || a_.size() != 0);
  }

 protected:
  bool advance(NodalState& state, double h, NodalReport& report) override {
    if (!known_) {
      a_.resize(state.x.size());
      system().force(state.x, state.v, ForcePart::kAll, a_);
      over_mass(a_);
    }
    x_hat_ = state.x + h * state.v + (0.25 * h * h) * a_;
    v_hat_ = -state.v;
    guess(state, h);
    hold_velocities(state, -1.0 / h);
    const ImplicitEquation equation{.mu = 4.0 / (h * h),
                                    .theta = 1.0,
                                    .kappa = 2.0 / h,
                                    .x0 = &state.x,
                                    .x_hat = &x_hat_,
                                    .v_hat = &v_hat_,
                                    .share = 0.5};
    if (!solve_->solve(equation, x1_, false, report)) return false;
    v1_ = (2.0 / h) * (x1_ - state.x) - state.v;
    a_ = (4.0 / (h * h)) * (x1_ - x_hat_);
    known_ = true;
    return finish_guarded(state, h, 0.5, report);
  }

 private:
  void over_mass(Eigen::VectorXd& f) const {
    for (Eigen::Index i = 0; i < system().mass().size(); ++i)
      f.segment<3>(3 * i) /= system().mass()[i];
  }

  bool known_ = false;
  Eigen::VectorXd a_;  // at the end of the last step, m/s^2
};

class Bdf2 : public ImplicitMethod {
 public:
  using ImplicitMethod::ImplicitMethod;
  std::string_view name() const override { return "bdf2"; }
  void reset() override { last_step_ = 0.0; }
  void carry(StateStream& stream) override {
    ImplicitMethod::carry(stream);
    stream(last_step_);
    carry_vector(stream, x_last_);
    carry_vector(stream, v_last_);
    stream.require(last_step_ == 0.0 || (x_last_.size() != 0 && v_last_.size() != 0));
  }

 protected:
  bool advance(NodalState& state, double h, NodalReport& report) override {
    keep_x_ = state.x;
    keep_v_ = state.v;
    const bool begins = last_step_ != h;
    if (!begins) {
      x_hat_ = (4.0 * state.x - x_last_) / 3.0;
      v_hat_ = (1.5 / h) * (state.x - x_hat_);
      far_ = x_hat_ + (2.0 * h / 9.0) * (4.0 * state.v - v_last_);
      guess(state, h);
      hold_velocities(state, -0.5 / h);
      const ImplicitEquation equation{.mu = 2.25 / (h * h),
                                      .theta = 1.0,
                                      .kappa = 1.5 / h,
                                      .x0 = &state.x,
                                      .x_hat = &far_,
                                      .v_hat = &v_hat_,
                                      .share = 2.0 / 3.0};
      if (!solve_->solve(equation, x1_, false, report)) return false;
      v1_ = (1.5 / h) * (x1_ - x_hat_);
    } else {
      // The first step is the midpoint rule's, which is of second order too.
      guess(state, h);
      if (!solve_middle(state, h, false, report)) return false;
    }
    if (!finish_guarded(state, h, begins ? 1.0 : 2.0 / 3.0, report)) return false;
    x_last_.swap(keep_x_);
    v_last_.swap(keep_v_);
    last_step_ = h;
    return true;
  }

 private:
  double last_step_ = 0.0;  // s; 0: there is no last step
  Eigen::VectorXd x_last_, v_last_, keep_x_, keep_v_, far_;
};

}  // namespace

Result<std::unique_ptr<NodalIntegrator>> make_implicit(std::string_view name,
                                                       const NodalSystem& system,
                                                       const NodalOptions& options) {
  Result<std::unique_ptr<ImplicitSolve>> solve = ImplicitSolve::create(system, options);
  if (!solve) return solve.error();
  using Made = std::unique_ptr<NodalIntegrator>;
  if (name == "newmark") return Made(std::make_unique<Newmark>(system, options, std::move(*solve)));
  if (name == "bdf2") return Made(std::make_unique<Bdf2>(system, options, std::move(*solve)));
  if (name == "midpoint" || name == "energy")
    return Made(std::make_unique<Middle>(system, options, std::move(*solve), name == "energy"));
  return Made(std::make_unique<ImplicitEuler>(system, options, std::move(*solve),
                                              name == "implicit-euler-linear"));
}

}  // namespace tremolo
