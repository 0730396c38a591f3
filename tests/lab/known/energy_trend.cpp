#include "tests/lab/known/energy_trend.h"

#include <algorithm>
#include <cmath>

#include "runtime/apps/tremolo/output/statistics.h"
#include "tests/lab/known/quartic_model.h"
#include "tests/lab/known/spring_chain.h"
#include "tests/lab/work/failure.h"

namespace tremolo::known {

EnergyTrend measure_trend(std::string_view method, double tolerance, double step, long steps,
                          int windows) {
  const SpringChain chain = spring_chain();
  IntegratorOptions options{.step = step};
  options.split = {.rule = SplitRule::kCount, .count = 2};
  options.tolerance = tolerance;
  const auto integrator = or_fail(make_integrator(method, chain.model, options));
  const Potential& potential = chain.model->potential();
  PotentialWorkspace workspace = potential.make_workspace();
  Evaluation evaluation = potential.make_evaluation();
  State state = spring_chain_state(chain, 0.5);
  Eigen::VectorXd momentum = state.p;
  const auto energy = [&] {
    integrator->synchronized_momentum(state, momentum);
    potential.evaluate(state.q, kWantEnergy, workspace, evaluation);
    return 0.5 * momentum.squaredNorm() + evaluation.energy;
  };
  const StepLoad none = make_step_load(state.q.size());
  const double start = energy();
  const long length = steps / windows;
  EnergyTrend trend;
  trend.method = method;
  trend.tolerance = tolerance;
  trend.steps = steps;
  for (int window = 0; window < windows && trend.failure.empty(); ++window) {
    double sum = 0.0;
    for (long k = 0; k < length; ++k, ++trend.reached) {
      const StepReport report = integrator->step(state, none);
      if (report.iterations > 0) trend.implicit = true;
      if (!report.converged) trend.failure = "solver gave up";
      const double error = energy() / start - 1.0;
      if (!(error <= 9.0)) trend.failure = "energy bound left";
      if (!trend.failure.empty()) break;
      trend.largest = std::max(trend.largest, std::abs(error));
      sum += error;
    }
    if (trend.failure.empty()) trend.window_means.push_back(sum / static_cast<double>(length));
  }
  if (trend.failure.empty() && trend.window_means.size() > 2) {
    const Fit fit = fit_line(trend.window_means, 1.0);
    const double whole = static_cast<double>(windows);
    trend.slope = fit.slope * whole;
    trend.standard_error = fit.slope_error * whole;
  }
  return trend;
}

}  // namespace tremolo::known
