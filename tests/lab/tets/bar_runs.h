// A bar of tetrahedra, held at one end, that falls under its own weight: from very coarse to very
// fine, with linear, quadratic and adaptive edges, against a fine quadratic one.
//
// The bar is 0.4 x 0.1 x 0.1 m of density 1000 kg/m^3 and Poisson's ratio 0.4, cut into 4m x m x m
// cells of six tetrahedra. Error: the root mean square, over the steps and over 17 x 3 x 3 points
// of the bar, of the distance to where the reference has them in the same step, over the bar's
// length.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "runtime/tets/motion/degree_choice.h"

namespace tremolo::tets {

inline constexpr double kBarStep = 1.0 / 60.0;  // s
inline constexpr int kBarSteps = 60;

// cells: m. upper, lower: thresholds of adaptive edges.
struct BarCase {
  int cells = 1;
  double young = 2e5;  // Pa
  DegreeKind kind = DegreeKind::kQuadratic;
  double upper = 0.01, lower = 0.004;
};

// points: 3 for each point and step, m. seconds: processor time of all steps. share: of quadratic
// edges, the mean.
struct BarRun {
  std::vector<double> points;
  double seconds = 0.0;
  double share = 0.0;
  double elements = 0.0;
  double bytes = 0.0;
  double switched = 0.0;
  double switch_energy = 0.0;  // J
  double failed = 0.0;         // steps that could not be made
};
template <class Archive>
void fields(Archive& archive, BarRun& run) {
  archive("points", run.points, "seconds", run.seconds, "share", run.share, "elements",
          run.elements, "bytes", run.bytes, "switched", run.switched, "switch_energy",
          run.switch_energy, "failed", run.failed);
}

// Throws a Failure where the body cannot be made.
BarRun run_bar(const BarCase& wanted);

// Root mean square distance over the bar's length.
double bar_error(const BarRun& run, const BarRun& reference);

}  // namespace tremolo::tets
