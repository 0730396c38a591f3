// explicit-euler, symplectic-euler, explicit-midpoint, rk4 and implicit-euler-sweep: a(x, v) = f/m
//
//   explicit-euler        x1 = x0 + h v0, v1 = v0 + h a(x0, v0)
//   symplectic-euler      v1 = v0 + h a(x0, v0), x1 = x0 + h v1
//   explicit-midpoint     x1 = x0 + h v+, v1 = v0 + h a(x+, v+), + the middle by explicit Euler
//   rk4                   the means of four slopes, 1 2 2 1
//   implicit-euler-sweep  v1 = v0 + h a(x0 + h v0, v0 + h a(x0, v0)), x1 = x0 + h v1
#include "runtime/step/halved_step.h"

namespace tremolo {
namespace {

class ExplicitStep : public HalvedIntegrator {
 public:
  ExplicitStep(std::string_view name, const NodalSystem& system, const NodalOptions& options)
      : HalvedIntegrator(system, options), name_(name), rule_(rule_of(name)) {
    a_ = x1_ = v1_ = x_ = v_ = Eigen::VectorXd::Zero(3 * system.mass().size());
    if (name == "rk4")
      for (Eigen::VectorXd* sum : {&dx_, &dv_}) *sum = a_;
    inverse_mass_ = a_;
    reset();
  }
  std::string_view name() const override { return name_; }
  void carry(StateStream& stream) override {
    if (stream.reads()) reset();
  }
  // Nodes may have been fixed or released.
  void reset() final {
    for (Eigen::Index i = 0; i < system().mass().size(); ++i) {
      const bool held = system().held()[i] != 0;
      inverse_mass_.segment<3>(3 * i).setConstant(held ? 0.0 : 1.0 / system().mass()[i]);
    }
  }

 protected:
  bool advance(NodalState& state, double h, NodalReport& report) override {
    (this->*rule_)(state, h);
    put_held_nodes(system(), state.time + h, h, state.x, x1_, v1_);
    if (!x1_.allFinite() || !v1_.allFinite()) return false;
    ledger().begin(state);
    state.x.swap(x1_);
    state.v.swap(v1_);
    state.time += h;
    ledger().end(state, h, 0.0, report);
    return true;
  }

 private:
  void explicit_euler(const NodalState& state, double h) {
    accelerate(state.x, state.v);
    x1_ = state.x + h * state.v;
    v1_ = state.v + h * a_;
  }

  void symplectic_euler(const NodalState& state, double h) {
    accelerate(state.x, state.v);
    v1_ = state.v + h * a_;
    x1_ = state.x + h * v1_;
  }

  void explicit_midpoint(const NodalState& state, double h) {
    accelerate(state.x, state.v);
    x_ = state.x + 0.5 * h * state.v;
    v_ = state.v + 0.5 * h * a_;
    put_held_nodes(system(), state.time + 0.5 * h, 0.5 * h, state.x, x_, v_);
    accelerate(x_, v_);
    x1_ = state.x + h * v_;
    v1_ = state.v + h * a_;
  }

  void sweep(const NodalState& state, double h) {
    accelerate(state.x, state.v);
    x_ = state.x + h * state.v;
    v_ = state.v + h * a_;
    put_held_nodes(system(), state.time + h, h, state.x, x_, v_);
    accelerate(x_, v_);
    v1_ = state.v + h * a_;
    x1_ = state.x + h * v1_;
  }

  // a_ at (x, v); zero at held nodes.
  void accelerate(const Eigen::VectorXd& x, const Eigen::VectorXd& v) {
    system().force(x, v, ForcePart::kAll, a_);
    a_.array() *= inverse_mass_.array();
  }

  // Adds a slope, and moves from the state along it.
  void stage(const NodalState& state, double weight, double way, double h) {
    dx_ += weight * v_;
    dv_ += weight * a_;
    if (way == 0.0) return;
    x_ = state.x + way * h * v_;
    v_ = state.v + way * h * a_;
    put_held_nodes(system(), state.time + way * h, way * h, state.x, x_, v_);
    accelerate(x_, v_);
  }

  void runge_kutta(const NodalState& state, double h) {
    dx_.setZero();
    dv_.setZero();
    v_ = state.v;
    accelerate(state.x, state.v);
    stage(state, 1.0, 0.5, h);
    stage(state, 2.0, 0.5, h);
    stage(state, 2.0, 1.0, h);
    stage(state, 1.0, 0.0, h);
    x1_ = state.x + (h / 6.0) * dx_;
    v1_ = state.v + (h / 6.0) * dv_;
  }

  using Rule = void (ExplicitStep::*)(const NodalState&, double);
  static Rule rule_of(std::string_view name) {
    return name == "explicit-euler"      ? &ExplicitStep::explicit_euler
           : name == "symplectic-euler"  ? &ExplicitStep::symplectic_euler
           : name == "explicit-midpoint" ? &ExplicitStep::explicit_midpoint
           : name == "rk4"               ? &ExplicitStep::runge_kutta
                                         : &ExplicitStep::sweep;
  }

  std::string_view name_;
  Rule rule_;
  Eigen::VectorXd inverse_mass_, a_, x1_, v1_, x_, v_, dx_, dv_;
};

}  // namespace

std::unique_ptr<NodalIntegrator> make_explicit(std::string_view name, const NodalSystem& system,
                                               const NodalOptions& options) {
  return std::make_unique<ExplicitStep>(name, system, options);
}

}  // namespace tremolo
