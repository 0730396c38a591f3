#include "runtime/program/run/march.h"

#include <algorithm>

#include "common/processor_time.h"

namespace tremolo {

void look_at(const Body& body, Moment& moment) {
  moment.steps = body.steps();
  moment.time = body.time();
  moment.state.q = body.state().q;
  moment.state.p.resize(moment.state.q.size());
  body.integrator().synchronized_momentum(body.state(), moment.state.p);
  moment.work = body.work();
  moment.dissipated = body.dissipated();
  moment.iterations = body.iterations();
  moment.halved_steps = body.halved_steps();
  moment.loaded = body.load_to_come();
  moment.split = body.integrator().split();
  moment.bound = body.energy_bound();
}

March::March(Body& body, std::size_t block)
    : body_(body), moments_(std::max<std::size_t>(block, 1)) {
  for (Moment& moment : moments_) look_at(body, moment);
}

std::span<const Moment> March::advance(std::int64_t last) {
  std::size_t made = 0;
  const double before = processor_time();
  while (made < moments_.size() && body_.steps() < last && !failed_) {
    const StepReport report = body_.step();
    ++tried_;
    if (report.converged)
      look_at(body_, moments_[made++]);
    else
      failed_ = report;
  }
  seconds_ += processor_time() - before;
  return std::span(moments_).first(made);
}

double March::microseconds_per_step() const {
  return 1e6 * seconds_ / static_cast<double>(std::max<std::int64_t>(tried_, 1));
}

}  // namespace tremolo
