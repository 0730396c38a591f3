#include "runtime/step/halved_step.h"

#include <cmath>

namespace tremolo {

double free_kinetic(const NodalSystem& system, const Eigen::VectorXd& v) {
  const Eigen::VectorXd& mass = system.mass();
  const std::span<const std::uint8_t> held = system.held();
  double twice = 0.0;
  for (Eigen::Index i = 0; i < mass.size(); ++i)
    if (held[i] == 0) twice += mass[i] * v.segment<3>(3 * i).squaredNorm();
  return 0.5 * twice;
}

double held_work(const NodalSystem& system, const Eigen::VectorXd& f, const Eigen::VectorXd& x0,
                 const Eigen::VectorXd& x1) {
  const std::span<const std::uint8_t> held = system.held();
  double work = 0.0;
  for (std::size_t i = 0; i < held.size(); ++i) {
    const auto at = 3 * static_cast<Eigen::Index>(i);
    if (held[i] != 0) work -= f.segment<3>(at).dot(x1.segment<3>(at) - x0.segment<3>(at));
  }
  return work;
}

StepLedger::StepLedger(const NodalSystem& system, bool asked)
    : system_(system),
      asked_(asked),
      x0_(Eigen::VectorXd::Zero(3 * system.mass().size())),
      x_(x0_),
      v_(x0_),
      f_(x0_) {}

void StepLedger::begin(const NodalState& state) {
  if (!asked_) return;
  const std::optional<std::uint64_t> version = system_.potential_version();
  if (!version || version != version_ || state.x != x0_) {
    x0_ = state.x;
    potential_ = system_.potential(state.x);
    version_ = version;
  }
  energy_ = potential_ + free_kinetic(system_, state.v);
}

bool StepLedger::held_nodes_move(const Eigen::VectorXd& x1) const {
  const std::span<const std::uint8_t> held = system_.held();
  for (std::size_t i = 0; i < held.size(); ++i) {
    const auto at = 3 * static_cast<Eigen::Index>(i);
    if (held[i] != 0 && x1.segment<3>(at) != x0_.segment<3>(at)) return true;
  }
  return false;
}

void StepLedger::end(const NodalState& state, double h, double share, NodalReport& report) {
  if (!asked_) return;
  x_ = 0.5 * (x0_ + state.x);
  v_ = (state.x - x0_) / h;
  StepWork work = system_.power(x_, v_);
  work.damped *= h;
  work.driven *= h;
  double held = 0.0;
  if (held_nodes_move(state.x)) {
    system_.force(x_, v_, ForcePart::kAll, f_);
    held = held_work(system_, f_, x0_, state.x);
  }
  const NodalContact* contact = system_.contact();
  tell(state, work, held, contact ? contact->work(x0_, state.x, share) : 0.0, report);
}

void StepLedger::end(const NodalState& state, const StepWork& work, double held,
                     NodalReport& report) {
  if (!asked_) return;
  const NodalContact* contact = system_.contact();
  tell(state, work, held, contact ? contact->work(x0_, state.x, 1.0) : 0.0, report);
}

void StepLedger::tell(const NodalState& state, const StepWork& work, double held, double pressed,
                      NodalReport& report) {
  x0_ = state.x;
  const double before = potential_, kinetic = free_kinetic(system_, state.v);
  potential_ = system_.potential(state.x);
  turnover_ = kinetic + std::abs(potential_ - before);
  report.damped += work.damped;
  report.driven += work.driven;
  report.held_work += held;
  report.pressed += pressed;
  report.numerical += potential_ + kinetic - energy_ - held - pressed - work.driven + work.damped;
}

HalvedIntegrator::HalvedIntegrator(const NodalSystem& system, const NodalOptions& options)
    : system_(system), options_(options), ledger_(system, options.account) {
  before_.x = before_.v = Eigen::VectorXd::Zero(3 * system.mass().size());
}

NodalReport HalvedIntegrator::step(NodalState& state) {
  NodalReport report;
  before_ = state;
  const double end = state.time + options_.step;
  // Parts of the step are 2^-level of it; `left` is counted in the finest of them.
  const std::int64_t whole = std::int64_t{1} << options_.halvings;
  std::int64_t left = whole;
  int level = 0, parts = 0;
  while (left > 0) {
    const std::int64_t part = whole >> level;
    const double h = options_.step * static_cast<double>(part) / static_cast<double>(whole);
    if (part <= left && advance(state, h, report)) {
      left -= part;
      ++parts;
      // Reactions act in their part alone: no method saves them for the next.
      if (const NodalContact* contact = system_.contact(); contact && contact->pressed()) reset();
      continue;
    }
    if (++level > options_.halvings) {
      state = before_;
      reset();
      const int iterations = report.iterations;
      const double residual = report.residual;
      report = {};
      report.iterations = iterations;
      report.residual = residual;
      return report;
    }
    reset();
  }
  state.time = end;
  report.parts = parts;
  report.made = true;
  if (parts > 1) reset();
  return report;
}

void HalvedIntegrator::take_step(NodalState& state, double h, double share, Eigen::VectorXd& x1,
                                 Eigen::VectorXd& v1, NodalReport& report) {
  if (NodalContact* contact = system_.contact()) contact->keep(x1, h, share);
  ledger_.begin(state);
  state.x.swap(x1);
  state.v.swap(v1);
  state.time += h;
  ledger_.end(state, h, share, report);
}

void put_held_nodes(const NodalSystem& system, double time, double h, const Eigen::VectorXd& x0,
                    Eigen::VectorXd& x, Eigen::VectorXd& v) {
  const std::span<const std::uint8_t> held = system.held();
  for (std::size_t i = 0; i < held.size(); ++i) {
    const auto at = 3 * static_cast<Eigen::Index>(i);
    if (held[i] != 0) x.segment<3>(at) = x0.segment<3>(at);
  }
  system.put_held(time, x);
  for (std::size_t i = 0; i < held.size(); ++i) {
    const auto at = 3 * static_cast<Eigen::Index>(i);
    if (held[i] != 0) v.segment<3>(at) = (x.segment<3>(at) - x0.segment<3>(at)) / h;
  }
}

}  // namespace tremolo
