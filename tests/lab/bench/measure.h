// The measurements for each method, load, amplitude and step: the error, and separately the time.
#pragma once

#include <string>
#include <vector>

#include "tests/lab/bench/reference.h"

namespace tremolo::bench {

// One row of bench.csv. error: of the trajectory up to the reference's horizon, dimensionless,
// infinite where the run broke off before; below_reference: it is less than kAbove times the
// references' gap and only known to be below that. band_ratio: mean high-band energy of the second
// half over the reference's; not-a-number if the run did not get there. microseconds: a step;
// not-a-number if not timed.
struct Entry {
  std::size_t scene = 0;
  std::string integrator;
  double step = 0.0;
  double error = 0.0;
  bool below_reference = false;
  double drift = 0.0;
  double band_ratio = 0.0;
  double iterations = 0.0;
  double reached = 0.0;
  int exit_code = 0;
  std::string reason;
  double microseconds = 0.0;

  double cost() const { return 1e-3 * microseconds / step; }  // ms of computing a simulated second
};

// A hash of the running program: times measured with another build are not reused.
std::string build_id();

// A hash of the state after 100 steps of `step`: errors measured with a method that gave another
// state are not reused. Throws a Failure where the integrator cannot be made.
std::string fingerprint(const Scene& scene, const std::string& integrator, double step);

// One entry a step; `scene` and `microseconds` are left to the caller. Throws a Failure as
// fingerprint and the store.
std::vector<Entry> measure_errors(const Scene& scene, const Reference& reference,
                                  const std::string& integrator, const std::vector<double>& steps,
                                  const Store& store);

// Processor time per step of each integrator, microseconds: the smallest of five or more windows of
// steps after the load has ended (or after 0.3 s), each from the same state; the methods take
// turns, so that a noisy period affects all. Nothing else is done meanwhile. Not-a-number where a
// step did not converge. Throws a Failure as measure_errors.
std::vector<double> measure_times(const Scene& scene, const std::vector<std::string>& integrators,
                                  double step, const Store& store);

}  // namespace tremolo::bench
