#include "tests/lab/bench/sampled_run.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/energy.h"
#include "runtime/body.h"
#include "runtime/energy.h"
#include "tests/lab/work/failure.h"

namespace tremolo::bench {
namespace {

struct Progress {
  DriftMeter drift;
  double band_sum = 0.0;
  Eigen::Index band_count = 0;
};

// False: the orbit has left its bound.
bool observe(const Body& body, const Energy& energy, Progress& progress, SampledRun& run) {
  run.energy_end = energy.total();
  if (!body.energy_bound().sound(energy.total())) {
    run.bound_left();
    return false;
  }
  progress.drift.observe(energy.total(), body.sums().work, body.sums().dissipated,
                         body.load_to_come());
  if (body.load_to_come() || run.energy_reference == 0.0) run.energy_reference = energy.total();
  return true;
}

// False: the solver gave up.
bool advance(Body& body, Eigen::Index count, const RunSpec& spec, SampledRun& run) {
  for (Eigen::Index k = 0; k < count; ++k) {
    const StepReport step = body.step();
    if (!step.converged) {
      run.solver_gave_up(step);
      return false;
    }
    if (spec.watched.cols() > 0)
      run.largest = std::max(run.largest, (spec.watched * body.state().q).norm());
  }
  return true;
}

}  // namespace

SampledRun run_sampled(const RunSpec& spec) {
  Body body = or_fail(Body::create(spec.model, spec.integrator, spec.options));
  or_fail(body.add_load(spec.load));
  const Eigen::Index samples = std::llround(spec.duration / spec.sample);
  const Eigen::Index steps = std::llround(spec.sample / spec.options.step);
  SampledRun run;
  if (spec.keep_orbit) run.q.resize(spec.model->modes(), samples);
  Progress progress;
  Eigen::Index k = 0;
  for (bool inside = observe(body, body.energy(spec.band), progress, run); inside && k < samples;
       ++k) {
    if (!advance(body, steps, spec, run)) break;
    const Energy energy = body.energy(spec.band);
    if (!observe(body, energy, progress, run)) break;
    if (spec.keep_orbit) run.q.col(k) = body.state().q;
    if (2 * (k + 1) <= samples) continue;
    progress.band_sum += energy.high_band;
    ++progress.band_count;
  }
  if (spec.keep_orbit) run.q.conservativeResize(Eigen::NoChange, k);
  run.reached = body.time();
  run.drift = progress.drift.worst();
  run.high_band = k == samples ? progress.band_sum / static_cast<double>(progress.band_count)
                               : std::numeric_limits<double>::quiet_NaN();
  run.iterations_per_step = static_cast<double>(body.counts().iterations) /
                            static_cast<double>(std::max<std::int64_t>(body.counts().steps, 1));
  return run;
}

}  // namespace tremolo::bench
