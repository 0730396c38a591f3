#include "tests/lab/samples/thesis.h"

#include <cmath>

namespace tremolo::thesis {
namespace {

constexpr std::array<Modes, 6> kModes = {{{"beam", 15, 9, 6},
                                          {"basket", 20, 15, 5},
                                          {"bridge", 15, 13, 2},
                                          {"horse", 15, 9, 6},
                                          {"tower", 20, 11, 9},
                                          {"heart", 30, 27, 3}}};

constexpr SignalKind kImpulse = SignalKind::kImpulse;
constexpr SignalKind kSquare = SignalKind::kSquare;
constexpr SignalKind kSine = SignalKind::kSine;

constexpr std::array<Run, kRuns> kAllRuns = {{
    {5, 0.0, kImpulse, "beam", 1.89, 2.84, 1.0, 2.1, 1.50},
    {5, 0.0, kImpulse, "basket", 2.62, 4.89, 1.0, 2.1, 1.87},
    {5, 0.0, kImpulse, "bridge", 1.55, 2.56, 1.0, 2.1, 1.65},
    {5, 0.0, kImpulse, "horse", 2.64, 4.16, 1.0, 2.1, 1.58},
    {5, 0.0, kImpulse, "tower", 3.50, 4.94, 1.0, 2.1, 1.41},
    {5, 0.0, kImpulse, "heart", 5.68, 13.44, 0.7, 2.1, 2.37},
    {6, 0.0, kSquare, "beam", 1.89, 2.84, 1.0, 2.1, 1.50},
    {6, 0.0, kSquare, "basket", 2.62, 4.89, 1.0, 2.1, 1.87},
    {6, 0.0, kSquare, "bridge", 1.55, 2.56, 1.0, 2.1, 1.65},
    {6, 0.0, kSquare, "horse", 2.64, 4.16, 1.0, 2.1, 1.58},
    {6, 0.0, kSquare, "tower", 3.50, 4.94, 1.0, 2.1, 1.41},
    {6, 0.0, kSquare, "heart", 5.68, 13.44, 0.7, 2.1, 2.37},
    {7, 0.0, kSine, "beam", 2.26, 2.84, 1.1, 2.1, 1.25, 6.86},
    {7, 0.0, kSine, "basket", 2.85, 4.89, 1.0, 2.1, 1.71},
    {7, 0.0, kSine, "bridge", 1.93, 2.56, 1.0, 2.1, 1.33},
    {7, 0.0, kSine, "horse", 1.99, 4.16, 1.0, 2.1, 2.09},
    {7, 0.0, kSine, "tower", 4.78, 4.94, 1.0, 2.1, 1.03, 10.53},
    {7, 0.0, kSine, "heart", 6.12, 13.44, 1.0, 2.1, 2.19},
    {8, kAlpha, kImpulse, "beam", 2.26, 2.37, 2.0, 2.1, 1.05},
    {8, kAlpha, kImpulse, "basket", 2.71, 3.78, 1.0, 2.1, 1.40},
    {8, kAlpha, kImpulse, "bridge", 1.61, 5.57, 1.0, 2.1, 3.45},
    {8, kAlpha, kImpulse, "horse", 1.89, 6.34, 1.0, 2.1, 3.36},
    {8, kAlpha, kImpulse, "tower", 3.39, 5.12, 1.0, 2.1, 1.51},
    {8, kAlpha, kImpulse, "heart", 5.39, 13.86, 0.3, 2.1, 2.57},
    {9, kAlpha, kSquare, "beam", 1.88, 2.53, 1.0, 2.1, 1.35},
    {9, kAlpha, kSquare, "basket", 2.96, 6.87, 1.0, 2.0, 2.32},
    {9, kAlpha, kSquare, "bridge", 1.83, 2.60, 1.0, 1.7, 1.42},
    {9, kAlpha, kSquare, "horse", 2.12, 3.41, 1.0, 2.1, 1.61},
    {9, kAlpha, kSquare, "tower", 9.05, 9.98, 1.0, 2.1, 1.10},
    {9, kAlpha, kSquare, "heart", 12.69, 22.25, 0.8, 2.1, 1.75},
    {10, kAlpha, kSine, "beam", 2.12, 2.73, 1.0, 2.1, 1.29, 7.12},
    {10, kAlpha, kSine, "basket", 2.88, 5.65, 1.0, 2.0, 1.96},
    {10, kAlpha, kSine, "bridge", 1.77, 2.94, 1.0, 1.7, 1.67},
    {10, kAlpha, kSine, "horse", 2.11, 3.36, 1.0, 2.1, 1.59},
    {10, kAlpha, kSine, "tower", 13.59, 16.88, 1.0, 2.1, 1.24},
    {10, kAlpha, kSine, "heart", 17.47, 25.59, 1.0, 2.1, 1.46},
}};

}  // namespace

std::string_view load_name(SignalKind load) {
  if (load == kImpulse) return "impulse";
  return load == kSquare ? "square" : "sine";
}

const Modes* modes(std::string_view model) {
  for (const Modes& entry : kModes)
    if (entry.model == model) return &entry;
  return nullptr;
}

const std::array<Run, kRuns>& runs() {
  return kAllRuns;
}

const Run* run(std::string_view model, SignalKind load, double alpha) {
  for (const Run& entry : kAllRuns)
    if (entry.model == model && entry.load == load && std::abs(entry.alpha - alpha) < 1e-12)
      return &entry;
  return nullptr;
}

}  // namespace tremolo::thesis
