#include "runtime/nodal/halved_step.h"

#include <cmath>

namespace tremolo {

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
