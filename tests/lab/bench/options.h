// The options of `tremolo bench`.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"

namespace tremolo::bench {

// Empty lists mean all, or the default. amplitudes: largest displacement of the loaded vertex over
// the largest extent of the solid, dimensionless. Lengths of time in ms where the name says so,
// else in s.
struct Options {
  std::vector<std::string> models;
  std::string models_dir = "build/models";
  std::vector<std::string> integrators;
  std::vector<std::string> loads = {"square", "impulse", "sine"};
  std::vector<double> amplitudes = {0.01, 0.05, 0.15, 0.3};
  std::vector<double> steps_ms = {6, 3, 1.5, 0.75, 0.3, 0.1};
  double duration = 6.0;
  std::vector<double> stability_scales = {0.3, 1, 3, 10, 30};
  std::vector<double> stability_steps_ms = {10, 6, 3, 1.5, 0.75};
  double stability_duration = 30.0;
  std::string out = "build/bench";
  std::string only;      // precision, stability, speed, hand; empty: all
  unsigned threads = 0;  // 0: one a core
  bool json = false;
};

// Distance of the recorded samples, s. Every step of the precision part must divide it.
inline constexpr double kSample = 6e-3;

// Sorts the lists (steps from long to short, amplitudes and scales ascending, no value
// twice), names all integrators where none is named. Errors: kUsage for an unknown name (with the
// known ones) or --only; kContent for a value that is not positive and finite, a step that does not
// divide kSample, a duration that is too short or too long.
Status settle(Options& options);

}  // namespace tremolo::bench
