// Drift of the energy as a fit: a long free orbit, the mean of H over windows, a straight line
// through the means, and the standard error of its slope. The solver's tolerance is the control: a
// drift that follows it is the solver's, one that does not is the method's.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tremolo::known {

// slope, standard_error: relative change of H over the whole run, H1/H0 - 1 along the line.
// largest: max |H - H0| / H0. implicit: some step needed a solve. reached: steps made.
struct EnergyTrend {
  std::string method;
  double tolerance = 0.0;
  long steps = 0;
  long reached = 0;
  double slope = 0.0;
  double standard_error = 0.0;
  double largest = 0.0;
  bool implicit = false;
  std::string failure;
  std::vector<double> window_means;  // (H - H0) / H0
};

// `steps` of `step` seconds on the spring chain from half its strongly nonlinear state, in
// `windows` windows. Throws a Failure as make_integrator.
EnergyTrend measure_trend(std::string_view method, double tolerance, double step, long steps,
                          int windows);

}  // namespace tremolo::known
