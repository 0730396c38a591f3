// Curves of periodic motions as JSON, CSV and a page.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime/apps/tremolo/output/warnings.h"
#include "runtime/apps/tremolo/response/periodic_model.h"
#include "runtime/response/response.h"
#include "runtime/response/stepped_curve.h"

namespace tremolo {

// kMain: a response curve or a backbone. kFolds, kBranch: followed from the first of these.
enum class CurveRole { kMain, kFolds, kBranch };

// A finished curve.
struct CurveResult {
  std::string label;  // "load x 2", "mode 1"
  double load_scale = 1.0;
  CurveRole role = CurveRole::kMain;
  MotionCurve curve;
  double seconds = 0.0;  // of computing
  double processor_seconds = 0.0;
  std::optional<SteppedCurve> stepped;  // of --by-stepping
  int exit_code = 0;
  std::string reason;  // why exit_code is not 0
  Warnings warnings;
};

// The values of one point that files and charts show.
struct PointValues {
  double frequency = 0.0;         // Hz
  double amplitude = 0.0;         // of the probe, m
  double energy = 0.0;            // mean over the period, J
  double phase = 0.0;             // lag of the probe behind the load, degrees
  std::vector<double> harmonics;  // largest displacement of the probe by each, m, from the mean on
};

// Context of the values. direction: of the displacement whose phase is meant, 3; load_phase: rad.
struct CurveContext {
  const PeriodicModel& made;
  VibratingSystem system;
  Eigen::Vector3d direction;
  double load_phase = 0.0;
  bool forced = true;      // the points have a phase and stability against a load
  bool ridge = false;      // a damped backbone: each point has a load of its own
  ProbeResponse response;  // of the probe at the load scale 1
};
// load_scale: of the curve (CurveResult).
PointValues values_of(const CurvePoint& point, double load_scale, const CurveContext& context);

// points, folds, bifurcations, end, reason and seconds of one curve.
nlohmann::ordered_json curve_json(const CurveResult& result, const CurveContext& context);

// A line for each point of all curves. The column load_scale is left out of backbones.
std::string curve_table(const std::vector<CurveResult>& results, const CurveContext& context);

// A page with the curves: stable parts solid, unstable parts dashed, folds and bifurcations marked;
// a click on a point plays its motion. Errors: orbit_film's.
Result<std::string> curve_page(const std::string& title, const std::string& subtitle,
                               const std::vector<CurveResult>& results,
                               const CurveContext& context);

// One line for each curve on stderr, its warnings and its reason.
void print_curve(const CurveResult& result, const CurveContext& context);

// The exit code and the reason of the curve's end. to: of the last frequency or amplitude, for the
// message.
void set_ending(const PeriodicModel& made, bool damped, const std::string& to,
                const CurveOptions& options, CurveResult& result);

}  // namespace tremolo
