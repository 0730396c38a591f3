// Published values of the thesis: Huang 2011, "Preserving High-Frequency Vibration of Deformable
// Objects Using the Implicit-Explicit Variational Integrator", tables 1, 3 and 5-10, experiment 3.
// The numbers are in assets/published/thesis-*.csv.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/load.h"

namespace tremolo::thesis {

inline constexpr double kStep = 3e-3;      // s
inline constexpr double kDuration = 30.0;  // s
inline constexpr double kAlpha = 0.3;      // 1/s, the damped runs

inline constexpr std::array<std::string_view, 6> kModels = {"beam",  "basket", "bridge",
                                                            "horse", "tower",  "heart"};
inline constexpr std::array<SignalKind, 3> kLoads = {SignalKind::kImpulse, SignalKind::kSquare,
                                                     SignalKind::kSine};
inline constexpr std::array<double, 2> kAlphas = {0.0, kAlpha};
inline constexpr std::size_t kRuns = kModels.size() * kLoads.size() * kAlphas.size();

// "impulse", "square", "sine".
std::string_view load_name(SignalKind load);

// Table 1: coordinates, and those of them that are explicit and implicit.
struct Modes {
  std::string model;
  int r = 0, low = 0, high = 0;
};

// Tables 3 and 5-10. table: which one of 5-10 prints the seconds for the run, the iterations a step
// and the speed-up. reached: simulated seconds of IMEXv out of 30.
struct Run {
  int table = 0;
  double alpha = 0.0;
  SignalKind load = SignalKind::kImpulse;
  std::string model = {};
  double imexv_seconds = 0.0, newmark_seconds = 0.0;
  double imexv_iterations = 0.0, newmark_iterations = 0.0;
  double speedup = 0.0;
  double reached = kDuration;

  bool finished() const { return reached >= kDuration; }
};

// total_change, high_band_change: experiment 3, last 35 s against the first, relative.
struct Thesis {
  std::vector<Modes> modes;
  std::vector<Run> runs;
  double total_change = 0.0;
  double high_band_change = 0.0;

  // nullptr for a model that is not in the thesis. After read_thesis every model of kModels and
  // every combination of kModels, kLoads and kAlphas exists.
  const Modes* modes_of(std::string_view model) const;
  const Run* run(std::string_view model, SignalKind load, double alpha) const;
};

// Throws a Failure as PublishedTable, and kContent for a run or a model that is missing or there
// twice.
Thesis read_thesis(const std::string& directory);

}  // namespace tremolo::thesis
