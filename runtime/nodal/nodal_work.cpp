#include "runtime/nodal/nodal_work.h"

namespace tremolo {

double free_kinetic(const NodalSystem& system, const Eigen::VectorXd& v) {
  const Eigen::VectorXd& mass = system.mass();
  const std::span<const std::uint8_t> held = system.held();
  double twice = 0.0;
  for (Eigen::Index i = 0; i < mass.size(); ++i)
    if (held[static_cast<std::size_t>(i)] == 0)
      twice += mass[i] * v.segment<3>(3 * i).squaredNorm();
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

StepLedger::StepLedger(const NodalSystem& system)
    : system_(system),
      x0_(Eigen::VectorXd::Zero(3 * system.mass().size())),
      x_(x0_),
      v_(x0_),
      f_(x0_) {}

void StepLedger::begin(const NodalState& state) {
  x0_ = state.x;
  energy_ = system_.potential(state.x) + free_kinetic(system_, state.v);
}

void StepLedger::end(const NodalState& state, double h, NodalReport& report) {
  x_ = 0.5 * (x0_ + state.x);
  v_ = (state.x - x0_) / h;
  StepWork work = system_.power(x_, v_);
  work.damped *= h;
  work.driven *= h;
  system_.force(x_, v_, ForcePart::kAll, f_);
  end(state, work, held_work(system_, f_, x0_, state.x), report);
}

void StepLedger::end(const NodalState& state, const StepWork& work, double held,
                     NodalReport& report) {
  const double energy = system_.potential(state.x) + free_kinetic(system_, state.v);
  report.damped += work.damped;
  report.driven += work.driven;
  report.held_work += held;
  report.numerical += energy - energy_ - held - work.driven + work.damped;
}

}  // namespace tremolo
