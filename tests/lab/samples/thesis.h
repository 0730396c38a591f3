// The numbers that the thesis prints: Huang 2011, "Preserving High-Frequency Vibration of
// Deformable Objects Using the Implicit-Explicit Variational Integrator", tables 1, 3 and 5-10,
// experiment 3.
//
// As printed. Table 5 repeats table 6, and so does the Newmark column of table 7; runs that table 3
// lists as failed still have a speed-up.
#pragma once

#include <array>
#include <string_view>

#include "runtime/load.h"

namespace tremolo::thesis {

inline constexpr double kStep = 3e-3;         // s
inline constexpr double kDuration = 30.0;     // s
inline constexpr double kAlpha = 0.3;         // 1/s, the damped runs
inline constexpr double kTotalChange = 0.02;  // experiment 3, last 35 s against the first
inline constexpr double kHighBandChange = -0.28;

inline constexpr std::array<std::string_view, 6> kModels = {"beam",  "basket", "bridge",
                                                            "horse", "tower",  "heart"};
inline constexpr std::array<SignalKind, 3> kLoads = {SignalKind::kImpulse, SignalKind::kSquare,
                                                     SignalKind::kSine};
inline constexpr std::array<double, 2> kAlphas = {0.0, kAlpha};
inline constexpr std::size_t kRuns = kModels.size() * kLoads.size() * kAlphas.size();

// "impulse", "square", "sine".
std::string_view load_name(SignalKind load);

// Table 1. Errors: the model must be one of kModels, here and below; else nullptr.
struct Modes {
  std::string_view model;
  int r, low, high;
};
const Modes* modes(std::string_view model);

// Tables 3 and 5-10. reached: simulated seconds of IMEXv out of 30. table: which one of 5-10 prints
// the seconds for the run, the iterations a step and the speed-up.
struct Run {
  int table;
  double alpha;
  SignalKind load;
  std::string_view model;
  double imexv_seconds, newmark_seconds;
  double imexv_iterations, newmark_iterations;
  double speedup;
  double reached = kDuration;
};
const std::array<Run, kRuns>& runs();
const Run* run(std::string_view model, SignalKind load, double alpha);

}  // namespace tremolo::thesis
