#include "runtime/apps/tremolo/response/curve_report.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "common/units.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/output/text_values.h"
#include "runtime/response/backbone.h"

namespace tremolo {
namespace {

using Json = nlohmann::ordered_json;

double in_hertz(double omega) {
  return omega / (2.0 * std::numbers::pi);
}

// The largest |a cos theta + b sin theta|.
double semi_axis(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const double half = 0.5 * (a.squaredNorm() + b.squaredNorm());
  const double difference = 0.5 * (a.squaredNorm() - b.squaredNorm());
  return std::sqrt(half + std::hypot(difference, a.dot(b)));
}

// True if each point of the curve has a load of its own.
bool own_loads(const CurveResult& result, const CurveContext& context) {
  return context.ridge || result.role == CurveRole::kFolds;
}

Json point_json(const CurveResult& result, const CurvePoint& point, const CurveContext& context) {
  const PointValues values = values_of(point, result.load_scale, context);
  Json json;
  json["frequency_hz"] = values.frequency;
  json["amplitude"] = values.amplitude;
  json["energy"] = values.energy;
  json["stable"] = point.multipliers.size() > 0 ? Json(point.stable) : Json(nullptr);
  json["harmonics"] = point.harmonics();
  if (context.forced) json["phase_deg"] = values.phase;
  if (own_loads(result, context)) json["load_scale"] = result.load_scale * point.load;
  json["harmonic_amplitudes"] = values.harmonics;
  json["last_harmonics_share"] = point.share;
  if (!context.forced || context.ridge) {
    const HarmonicPart part = largest_part(point.motion);
    json["resonance"] = {
        {"harmonic", part.harmonic}, {"mode", part.coordinate + 1}, {"share", part.share}};
  }
  return json;
}

Json bifurcation_json(const CurveResult& result, const Bifurcation& found,
                      const CurveContext& context) {
  const PointValues values = values_of(found.point, result.load_scale, context);
  Json json = {{"kind", name_of(found.kind)},
               {"frequency_hz", values.frequency},
               {"amplitude", values.amplitude},
               {"energy", values.energy},
               {"harmonics", found.point.harmonics()},
               {"imperfect", found.imperfect},
               {"multiplier", {found.multiplier.real(), found.multiplier.imag()}}};
  if (own_loads(result, context)) json["load_scale"] = result.load_scale * found.point.load;
  return json;
}

// Time stepping over harmonic balance, of processor time.
double cost_ratio(const CurveResult& result) {
  return result.stepped->seconds / result.processor_seconds;
}

Json stepped_json(const CurveResult& result) {
  const SteppedCurve& stepped = *result.stepped;
  return {{"processor_seconds", stepped.seconds},
          {"ratio", cost_ratio(result)},
          {"points", stepped.points},
          {"points_elsewhere", stepped.elsewhere},
          {"periods", stepped.periods},
          {"steps_per_period", stepped.steps},
          {"largest_difference", stepped.difference}};
}

const CurvePoint& peak_of(const MotionCurve& curve) {
  return *std::max_element(
      curve.points.begin(), curve.points.end(),
      [](const CurvePoint& a, const CurvePoint& b) { return a.amplitude < b.amplitude; });
}

}  // namespace

PointValues values_of(const CurvePoint& point, double load_scale, const CurveContext& context) {
  PointValues values;
  values.frequency = in_hertz(point.omega);
  values.amplitude = point.amplitude;
  values.energy = mean_energy(context.system, point.motion, point.omega);
  const FourierSeries seen = shown_motion(context.made.the_probe(), context.response, point.motion,
                                          load_scale * point.load);
  const Eigen::Index H = harmonics_of(seen);
  values.harmonics.push_back(seen.col(0).norm());
  for (Eigen::Index k = 1; k <= H; ++k)
    values.harmonics.push_back(semi_axis(seen.col(cosine_column(k)), seen.col(sine_column(k))));
  // a cos theta + b sin theta = A sin(theta + atan2(a, b)).
  const double a = context.direction.dot(seen.col(cosine_column(1)));
  const double b = context.direction.dot(seen.col(sine_column(1)));
  const double lag = (context.load_phase - std::atan2(a, b)) * 180.0 / std::numbers::pi;
  values.phase = lag - 360.0 * std::floor((lag + 90.0) / 360.0);
  return values;
}

Json curve_json(const CurveResult& result, const CurveContext& context) {
  Json json;
  const MotionCurve& curve = result.curve;
  json["points"] = Json::array();
  for (const CurvePoint& point : curve.points)
    json["points"].push_back(point_json(result, point, context));
  json["folds"] = Json::array();
  json["bifurcations"] = Json::array();
  for (const Bifurcation& found : curve.bifurcations) {
    const Json one = bifurcation_json(result, found, context);
    json["bifurcations"].push_back(one);
    if (found.kind == BifurcationKind::kFold) json["folds"].push_back(one);
  }
  if (!curve.points.empty()) {
    const CurvePoint& peak = peak_of(curve);
    json["peak"] = {{"frequency_hz", in_hertz(peak.omega)}, {"amplitude", peak.amplitude}};
  }
  json["last_harmonics_share"] = curve.largest_share;
  json["end"] = name_of(curve.end);
  json["exit_code"] = result.exit_code;
  json["reason"] = result.reason.empty() ? Json(nullptr) : Json(result.reason);
  json["warnings"] = result.warnings;
  json["seconds"] = result.seconds;
  json["processor_seconds"] = result.processor_seconds;
  if (result.stepped) json["by_stepping"] = stepped_json(result);
  return json;
}

std::string curve_table(const std::vector<CurveResult>& results, const CurveContext& context) {
  std::size_t most = 0;
  for (const CurveResult& result : results)
    for (const CurvePoint& point : result.curve.points)
      most = std::max(most, static_cast<std::size_t>(point.harmonics()));
  std::string text = context.forced
                         ? "load_scale,frequency_hz,amplitude,stable,harmonics,energy,phase_deg"
                         : "frequency_hz,amplitude,stable,harmonics,energy";
  for (std::size_t k = 0; k <= most; ++k) text += fmt::format(",harmonic_{}", k);
  text += '\n';
  for (const CurveResult& result : results)
    for (const CurvePoint& point : result.curve.points) {
      const PointValues values = values_of(point, result.load_scale, context);
      if (context.forced) text += fmt::format("{},", result.load_scale * point.load);
      const char* stable = point.multipliers.size() == 0 ? "" : point.stable ? "1" : "0";
      text += fmt::format("{},{},{},{},{}", values.frequency, values.amplitude, stable,
                          point.harmonics(), values.energy);
      if (context.forced) text += fmt::format(",{}", values.phase);
      for (std::size_t k = 0; k <= most; ++k)
        text += k < values.harmonics.size() ? fmt::format(",{}", values.harmonics[k])
                                            : std::string(",");
      text += '\n';
    }
  return text;
}

void print_curve(const CurveResult& result, const CurveContext& context) {
  const MotionCurve& curve = result.curve;
  if (!curve.points.empty()) {
    const CurvePoint& peak = peak_of(curve);
    tell(
        "{}: {} points in {:.3g} s, largest amplitude {:.4g} m ({:.3g} % of the size) at {:.6g} "
        "Hz\n",
        result.label, curve.points.size(), result.seconds, peak.amplitude,
        100.0 * peak.amplitude / context.made.size, in_hertz(peak.omega));
  }
  if (result.stepped) {
    const SteppedCurve& stepped = *result.stepped;
    tell(
        "  by time stepping its {} stable points take {:.3g} s of the processor, {:.3g} times the "
        "{:.3g} s of the curve: {} steps a period, {:.0f} periods a point, amplitudes within {:.1e}"
        "{}\n",
        stepped.points, stepped.seconds, cost_ratio(result), result.processor_seconds,
        stepped.steps, stepped.periods / stepped.points, stepped.difference,
        stepped.elsewhere > 0 ? fmt::format("; {} settled elsewhere", stepped.elsewhere) : "");
  }
  for (const Bifurcation& found : curve.bifurcations)
    tell("  {}{} at {:.6g} Hz, amplitude {:.4g} m\n", name_of(found.kind),
         found.imperfect ? ", imperfect (two curves with a gap narrower than the step)," : "",
         in_hertz(found.point.omega), found.point.amplitude);
  print_warnings(result.warnings);
}

namespace {

void add_warnings(bool damped, const CurveOptions& options, CurveResult& result) {
  const MotionCurve& curve = result.curve;
  if (curve.refused > 0)
    result.warnings.push_back(
        fmt::format("{} points, the first at {:.6g} Hz, have too few harmonics: with more of them "
                    "no motion was found; --harmonics begins with more",
                    curve.refused, in_hertz(curve.first_refused)));
  if (curve.longest_step > 0.0)
    result.warnings.push_back(fmt::format(
        "steps of {:.3g} led onto a closed loop, which a backbone does not reach; with steps of "
        "{:.3g} it stays off the loop",
        options.longest_step, curve.longest_step));
  if (!damped)
    result.warnings.push_back(
        "without damping no motion attracts others: stability was not computed");
  if (curve.largest_share > options.harmonic_share)
    result.warnings.push_back(fmt::format(
        "the two highest harmonics hold up to {:.2g} % of the motion, more than {:.2g} %: raise "
        "--most-harmonics above {}",
        100.0 * curve.largest_share, 100.0 * options.harmonic_share, options.most_harmonics));
}

}  // namespace

void set_ending(const PeriodicModel& made, bool damped, const std::string& to,
                const CurveOptions& options, CurveResult& result) {
  MotionCurve& curve = result.curve;
  // An undamped curve that has no end is unbounded, whatever stopped it.
  if (!damped && curve.end != CurveEnd::kDone && curve.end != CurveEnd::kStopped)
    curve.end = CurveEnd::kUnbounded;
  const CurvePoint& last = curve.points.back();
  const std::string where = fmt::format("at {:.6g} Hz and an amplitude of {:.4g} m",
                                        in_hertz(last.omega), last.amplitude);
  const auto end = [&](int code, const std::string& reason) {
    result.exit_code = code;
    result.reason = "the curve ends " + where + ": " + reason;
  };
  if (curve.end == CurveEnd::kUnbounded)
    end(exit_code(ErrorKind::kBound),
        damped ? fmt::format("the amplitude is above the body's size, {:.4g} m, where no model is "
                             "valid; use a smaller load or more damping",
                             made.size)
               : "without damping the response is unbounded at resonance; give a damping, such as "
                 "--damping-ratio 2%");
  else if (curve.end == CurveEnd::kReturned)
    end(exit_code(ErrorKind::kSolver),
        "it turned back and left the range where it had begun, so that no part of it reaches " +
            to);
  else if (curve.end == CurveEnd::kJoined)
    end(exit_code(ErrorKind::kSolver),
        fmt::format("it has joined the backbone of a mode of twice the frequency, {:.6g} Hz, from "
                    "which it branches off by period doubling; no part beyond this internal "
                    "resonance was found up to {}",
                    2.0 * in_hertz(last.omega), to));
  else if (curve.end == CurveEnd::kLoop)
    end(exit_code(ErrorKind::kSolver),
        fmt::format(
            "it has come back onto its own point {} at {:.6g} Hz: a closed loop, of which no "
            "part reaches {}. A curve does not lead onto a loop by itself: one of its steps "
            "has crossed a narrow gap; a smaller --longest-step may stay off the loop",
            curve.loop_start + 1, in_hertz(curve.points[curve.loop_start].omega), to));
  else if (curve.end == CurveEnd::kCoarse)
    end(exit_code(ErrorKind::kSolver),
        fmt::format("the two highest harmonics hold {:.2g} % of the motion, too much for it to "
                    "repeat; raise --most-harmonics above {}",
                    100.0 * last.share, last.harmonics()));
  else if (curve.end == CurveEnd::kStuck)
    end(exit_code(ErrorKind::kSolver),
        "no further point was found, even with the shortest step; more harmonics "
        "(--most-harmonics) may help");
  else if (curve.end == CurveEnd::kLong)
    end(exit_code(ErrorKind::kSolver),
        fmt::format("it has {} points and has not reached {}; raise --most-points or "
                    "--longest-step",
                    curve.points.size(), to));
  add_warnings(damped, options, result);
}

}  // namespace tremolo
