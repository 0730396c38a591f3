// The stability of each method over load and step.
#pragma once

#include <string>
#include <vector>

#include "tests/lab/bench/options.h"
#include "tests/lab/bench/scene.h"
#include "tests/lab/report/report.h"

namespace tremolo::bench {

// Survives: the energy of the free motion stays within kSurvives of that at the end of the load.
// Grows, decays: reaches the end with more or less than that. Dies: the solver gives up or the
// energy bound is left (exit codes 4 and 5).
enum class Outcome { kSurvives, kGrows, kDecays, kDies };
inline constexpr double kSurvives = 0.10;

const char* name_of(Outcome outcome);

// One run of the square load times `scale`. drift: energy_drift_max, seen every 30 ms.
struct StabilityCell {
  std::string model = {};
  std::string integrator = {};
  double scale = 0.0;
  double step = 0.0;  // s
  Outcome outcome = Outcome::kDies;
  double reached = 0.0;  // s
  double drift = 0.0;
  std::string reason = {};
};

// For each model, each integrator, each scale (ascending), each step (from long to short), in that
// order. Does not depend on the number of threads. Throws a Failure as run_sampled and the store.
std::vector<StabilityCell> measure_stability(const Options& options,
                                             const std::vector<Subject>& subjects,
                                             const Store& store);

// A section with maps and counts, and stability.csv. Throws a Failure (kSystem).
void report_stability(const std::vector<StabilityCell>& cells, const Options& options,
                      Report& report);

}  // namespace tremolo::bench
