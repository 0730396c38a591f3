// One run of one model from rest, sampled at equal intervals of time whatever its step is.
#pragma once

#include <cstdint>
#include <string>

#include <Eigen/Core>

#include "runtime/apps/tremolo/output/warnings.h"
#include "runtime/integrator.h"
#include "runtime/load.h"
#include "runtime/model.h"

namespace tremolo::bench {

// load: signal and reduced force. sample: s, a multiple of options.step. watched: 3 x r rows of a
// vertex whose largest displacement is asked for; empty: none. band: first coordinate of the high
// band, the same for all steps.
struct RunSpec {
  Model::Pointer model;
  std::string integrator;
  IntegratorOptions options;
  Load load;
  double duration = 6.0;
  double sample = 6e-3;
  Eigen::Index band = 0;
  bool keep_orbit = false;
  Eigen::Matrix<double, 3, Eigen::Dynamic> watched = {};
};

// q: r x samples, column k at (k + 1) sample; empty unless asked for. high_band: mean over the
// samples of the second half of the run, J, not-a-number if that was not reached. drift:
// energy_drift_max of docs/reference.md, of the samples. energy_reference: when the load had
// ended; energy_end: of the last sample. largest: of the watched vertex, over all steps, m.
struct SampledRun : Ending {
  Eigen::MatrixXd q;
  double high_band = 0.0;
  double drift = 0.0;
  double energy_reference = 0.0;
  double energy_end = 0.0;
  double largest = 0.0;
  double iterations_per_step = 0.0;
  double reached = 0.0;  // s
};

// Throws a Failure where the integrator cannot be made. A run that broke off is a result.
SampledRun run_sampled(const RunSpec& spec);

}  // namespace tremolo::bench
