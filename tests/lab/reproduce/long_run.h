// Experiment 3 of the thesis: one model after one impulse, free for millions of steps.
//
// The run is divided into segments of a fixed number of steps. At the start of each the body is
// made again from (q, p), whether or not the program was stopped there. A run that was stopped and
// continued therefore gives the same bits as one that was not.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "runtime/apps/tremolo/output/warnings.h"
#include "runtime/model.h"

namespace tremolo::reproduce {

// Means of a series that arrives value by value, cut into windows of `length` values each, from the
// first on, and, because the end need not coincide with a window's, its last `length` values once
// more. The whole has `count` values; an unfinished window at the end counts in `last` only. Plain
// data: a series that is written here and read back continues as if it had never stopped.
struct Windows {
  std::int64_t length = 1;
  std::int64_t count = 1;
  std::int64_t taken = 0;
  double sum = 0.0;           // of the unfinished window
  std::vector<double> means;  // of the finished ones
  std::vector<double> first;  // the values of the first window
  std::vector<double> last;   // the last `length` values of the whole

  void take(double value);
};

// step: s. steps: of the whole run. H and the high band are evaluated every `sample_every` steps;
// `window` samples are a window. segment: steps, a multiple of sample_every. low: where the high
// band begins, and the split of methods that split. tolerance: of the solve.
struct LongRunSpec {
  Model::Pointer model;
  std::string integrator;
  double step = 3e-3;
  std::int64_t steps = 0;
  std::int64_t sample_every = 10;
  std::int64_t window = 1167;
  std::int64_t segment = 100000;
  int low = 0;
  double tolerance = 1e-9;
};

// done: steps. reference: H when the load had ended, J. drift: max |H - reference| / reference over
// the samples. total, high_band: J.
struct LongRun : Ending {
  std::int64_t done = 0;
  Eigen::VectorXd q;
  Eigen::VectorXd p;
  double reference = 0.0;
  double drift = 0.0;
  std::int64_t iterations = 0;
  Windows total;
  Windows high_band;
};

nlohmann::json to_json(const LongRun& run);
// Throws a Failure (kContent) if it is not what to_json made.
LongRun long_run_from_json(const nlohmann::json& json);

// The steps with the model's default load as an impulse, and one more: the two-stage method hands
// on half of a step's load with the next step. Throws a Failure as Body::create and
// add_default_load.
LongRun start_long_run(const LongRunSpec& spec);

bool is_over(const LongRunSpec& spec, const LongRun& run);

// Runs one more segment, or the rest. A run that ends early is finished, not an error.
void advance(const LongRunSpec& spec, LongRun& run);

// Runs to the end. `checkpoint` stores the state, with `key`, and is written about every 20 s; a
// file with another key or a damaged one is not used. It is not removed here: the caller removes it
// after storing the result. report: called after each writing. Throws a Failure as start_long_run,
// and kSystem for an unwritable checkpoint.
LongRun run_to_end(const LongRunSpec& spec, const std::string& checkpoint,
                   const nlohmann::json& key, const std::function<void(const LongRun&)>& report);

}  // namespace tremolo::reproduce
