// Shapes of tetrahedra, fixed at one end, that fall under their own weight, with linear, quadratic
// and adaptive edges; several cases alternately, so that their times can be compared.
//
// Density 1000 kg/m^3, Poisson's ratio 0.4. Distance of two runs: the root mean square, over the
// steps and over the shape's points, of the distance between them, over the shape's size.
#pragma once

#include <string>
#include <vector>

#include <fmt/format.h>

#include "runtime/bodies/tets/motion/degree_choice.h"
#include "tests/lab/tets/shapes.h"

namespace tremolo::tets {

inline constexpr double kRunStep = 1.0 / 60.0;  // s
inline constexpr int kRunSteps = 60;
// An edge bends where its control point is off the mean of its ends by more than this fraction of
// its length.
inline constexpr double kBentEdge = 0.001;

// cells: m of the shape. young: Pa. error: of adaptive edges (degree_choice.h).
struct BodyCase {
  ShapeKind shape = ShapeKind::kBar;
  int cells = 1;
  double young = 2e5;
  DegreeKind kind = DegreeKind::kQuadratic;
  double error = 0.05;
};

// points: 3 for each point and step, m. seconds: processor time of all steps, one for each round.
// share: of quadratic edges; bent: of edges that bend; both the mean over the steps.
struct BodyRun {
  std::vector<double> points, seconds;
  double share = 0.0, bent = 0.0;
  double elements = 0.0, bytes = 0.0;
  double switched = 0.0, switch_energy = 0.0;  // J
  double failed = 0.0;                         // steps that could not be made
};
template <class Archive>
void fields(Archive& archive, BodyRun& run) {
  archive("points", run.points, "seconds", run.seconds, "share", run.share, "bent", run.bent,
          "elements", run.elements, "bytes", run.bytes, "switched", run.switched, "switch_energy",
          run.switch_energy, "failed", run.failed);
}

// Cases that were run alternately.
struct BodyRuns {
  std::vector<BodyRun> runs;
};
template <class Archive>
void fields(Archive& archive, BodyRuns& group) {
  double count = static_cast<double>(group.runs.size());
  archive("count", count);
  group.runs.resize(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < group.runs.size(); ++i)
    archive(fmt::format("run-{}", i).c_str(), group.runs[i]);
}

// Runs each case once, then all again, `turns` times. Throws a Failure where a body cannot be made.
BodyRuns run_by_turns(const std::vector<BodyCase>& cases, int turns);

double run_distance(const BodyRun& a, const BodyRun& b, double size);
// The middle one of the rounds' times, s; of the rounds' ratios to another run.
double middle_time(const BodyRun& run);
double middle_ratio(const BodyRun& run, const BodyRun& to);

}  // namespace tremolo::tets
