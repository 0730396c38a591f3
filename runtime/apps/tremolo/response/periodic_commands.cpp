#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "common/damping_ratios.h"
#include "common/processor.h"
#include "common/text.h"
#include "common/units.h"
#include "formats/file/atomic_file.h"
#include "formats/file/output_guard.h"
#include "runtime/apps/tremolo/output/run_progress.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/response/curve_report.h"
#include "runtime/apps/tremolo/response/orbit_file.h"
#include "runtime/apps/tremolo/response/periodic_model.h"
#include "runtime/apps/tremolo/response/response_commands.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/run/run_files.h"
#include "runtime/bodies/reduced/integrators/solve/damping.h"
#include "runtime/response/backbone.h"
#include "runtime/response/branches.h"
#include "runtime/response/probe.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

double in_radians(double frequency) {
  return 2.0 * std::numbers::pi * frequency;
}

// The files that a command writes. name: of those in --out, without ending.
struct PeriodicFiles {
  std::vector<std::string> tables, pages, reports, orbits;

  PeriodicFiles(const PeriodicOptions& options, const std::string& name)
      : orbits(options.orbit_files) {
    if (!options.csv.empty()) tables.push_back(options.csv);
    if (!options.page.empty()) pages.push_back(options.page);
    if (options.out.empty()) return;
    const auto in_folder = [&](const char* ending) {
      return (fs::path(options.out) / (name + ending)).string();
    };
    tables.push_back(in_folder(".csv"));
    pages.push_back(in_folder(".html"));
    reports.push_back(in_folder(".json"));
  }

  std::vector<std::string> all() const {
    std::vector<std::string> list = tables;
    list.insert(list.end(), pages.begin(), pages.end());
    list.insert(list.end(), reports.begin(), reports.end());
    list.insert(list.end(), orbits.begin(), orbits.end());
    return list;
  }

  // Errors: kUsage if one is an input or another output, or a page is not .html; kSystem.
  Status check(const PeriodicOptions& options, const std::vector<NamedFile>& inputs) const {
    for (const std::string& page : pages)
      if (fs::path(page).extension() != ".html")
        return usage_error("--page " + page + ": curves are drawn on a page, .html");
    if (Status s = check_orbit_flags(options); !s) return s;
    if (Status s = keep_apart(all(), inputs); !s) return s;
    if (Status s = check_writable({options.csv, options.page}); !s) return s;
    if (Status s = check_writable(orbits); !s) return s;
    return options.out.empty() ? Status(Success{}) : check_writable(all(), true);
  }
};

std::vector<NamedFile> inputs_of(const PeriodicOptions& options) {
  std::vector<NamedFile> inputs{{options.model, "the basis file"}};
  add_ids_of(options.at, "--at", inputs);
  add_ids_of(options.probe, "--probe", inputs);
  return inputs;
}

// The parts of a command's JSON that do not depend on the curve.
Json head_of(const PeriodicOptions& options, const PeriodicModel& made) {
  Json json;
  json["schema"] = kReportSchema;
  json["model"] = options.model;
  json["coordinates"] = made.model->modes();
  json["probe"] = made.probe;
  json["size"] = made.size;
  json["rigid_modes"] = made.model->rigid_mode_count();
  return json;
}

// All curves: at the top if there is only one, else as a list.
Json report_of(Json head, const std::vector<CurveResult>& results, const CurveContext& context,
               const std::vector<std::string>& files) {
  double seconds = 0.0;
  std::size_t mains = 0;
  for (const CurveResult& result : results) {
    seconds += result.seconds;
    mains += result.role == CurveRole::kMain ? 1 : 0;
  }
  for (const CurveResult& result : results) {
    if (mains == 1 && result.role == CurveRole::kMain) {
      if (context.forced && !context.ridge) head["load_scale"] = result.load_scale;
      head.update(curve_json(result, context));
      continue;
    }
    constexpr const char* kLists[] = {"curves", "fold_curves", "branches"};
    Json one = {{"load_scale", result.load_scale}};
    one.update(curve_json(result, context));
    head[kLists[static_cast<int>(result.role)]].push_back(std::move(one));
  }
  if (mains > 1) head["seconds"] = seconds;
  head["files"] = files;
  return head;
}

// Writes all files, prints the curves and the JSON. The exit code.
int finish(const PeriodicOptions& options, const PeriodicFiles& files, const std::string& title,
           const std::string& subtitle, const std::vector<CurveResult>& results,
           const CurveContext& context, const Json& head) {
  const Result<Json> orbit = write_orbit(options, results, context);
  int code = orbit ? 0 : report_error(orbit.error());
  // The motion is not on the curve: no file of the command is there.
  if (!orbit && orbit.error().kind == ErrorKind::kContent) return code;
  Json report = report_of(head, results, context, files.all());
  if (orbit && !orbit->is_null()) report["orbit"] = *orbit;
  if (!options.out.empty()) {
    std::error_code error;
    fs::create_directories(options.out, error);
  }
  for (const std::string& path : files.tables)
    if (Status s = write_file(path, curve_table(results, context)); !s)
      return report_error(s.error());
  if (!files.pages.empty()) {
    const Result<std::string> page = curve_page(title, subtitle, results, context);
    if (!page) return report_error(page.error());
    for (const std::string& path : files.pages)
      if (Status s = write_file(path, *page); !s) return report_error(s.error());
  }
  for (const std::string& path : files.reports)
    if (Status s = write_file(path, json_text(report)); !s) return report_error(s.error());
  for (const CurveResult& result : results) {
    print_curve(result, context);
    if (result.exit_code == 0) continue;
    tell("tremolo: {}: {}\n", result.label, result.reason);
    code = result.exit_code;
  }
  if (options.json) print_json(report);
  return flushed(code);
}

Result<LoadHarmonic> parse_load_harmonic(const std::string& text) {
  const Error wrong = usage_error("--load-harmonic " + text +
                                  ": expected K:SCALE or K:SCALE:DEGREES, as in 3:0.1:90");
  std::vector<double> numbers;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(':', at), text.size());
    double value = 0.0;
    const auto [stop, error] = read_decimal(text.data() + at, text.data() + end, value);
    if (error != std::errc{} || stop != text.data() + end) return wrong;
    numbers.push_back(value);
    at = end + 1;
  }
  if (numbers.size() < 2 || numbers.size() > 3) return wrong;
  if (!(numbers[0] >= 1.0) || numbers[0] > 99.0 || numbers[0] != std::floor(numbers[0]))
    return content_error("--load-harmonic " + text +
                         ": K must be a whole number from 1 to 99; a constant load is "
                         "--static-scale");
  if (!std::isfinite(numbers[1])) return content_error("--load-harmonic: SCALE must be finite");
  const double degrees = numbers.size() > 2 ? numbers[2] : 0.0;
  return LoadHarmonic{static_cast<int>(numbers[0]), numbers[1], degrees * std::numbers::pi / 180.0};
}

Result<FourierSeries> course_of(const ResponseOptions& options) {
  std::vector<LoadHarmonic> parts;
  for (const std::string& text : options.load_harmonics) {
    const Result<LoadHarmonic> part = parse_load_harmonic(text);
    if (!part) return part.error();
    parts.push_back(*part);
  }
  return load_course(parts);
}

Status check_frequencies(const ResponseOptions& options) {
  for (const auto& [flag, frequency] : {std::pair("--from", options.from), {"--to", options.to}})
    if (!(frequency > 0.0) || !std::isfinite(frequency))
      return content_error(fmt::format(
          "{} {}: the frequency of a periodic load must be positive and finite (Hz); a load at "
          "zero frequency is constant: tremolo run --start static",
          flag, frequency));
  if (options.from == options.to)
    return content_error("--from and --to are the same: a curve needs a range of frequencies");
  if (options.folds_to && (!std::isfinite(*options.folds_to) || *options.folds_to == 0.0))
    return content_error(
        "--folds-to must be finite and other than zero: without load nothing folds");
  return Success{};
}

// All of --load-scale. Errors: kUsage for an item that is not a number; kContent.
Result<std::vector<double>> load_scales_of(const ResponseOptions& options) {
  std::vector<double> scales;
  for (const std::string& list : options.load_scales)
    for (std::size_t at = 0; at <= list.size();) {
      const std::size_t end = std::min(list.find(',', at), list.size());
      double scale = 0.0;
      const auto [stop, error] = read_decimal(list.data() + at, list.data() + end, scale);
      if (error != std::errc{} || stop != list.data() + end)
        return usage_error("--load-scale " + list +
                           ": expected numbers with commas between, as in 1,2,5");
      if (!std::isfinite(scale) || scale == 0.0)
        return content_error("--load-scale must be finite and other than zero");
      scales.push_back(scale);
      at = end + 1;
    }
  return scales;
}

Result<VibratingSystem> system_of(const PeriodicOptions& options, const Model& model) {
  if (!(options.alpha >= 0.0) || !(options.beta >= 0.0) || !std::isfinite(options.alpha) ||
      !std::isfinite(options.beta))
    return content_error("--alpha and --beta must not be negative");
  double alpha = options.alpha, beta = options.beta;
  Eigen::VectorXd more;
  if (!options.damping_ratio.empty()) {
    const Result<DampingRatios> ratios = parse_damping(options.damping_ratio);
    if (!ratios) return ratios.error();
    alpha = ratios->rayleigh.alpha;
    beta = ratios->rayleigh.beta;
    if (Status s = check_ratios(*ratios, static_cast<std::size_t>(model.modes())); !s)
      return s.error();
    if (ratios->of_each_mode()) more = modal_rates(*ratios, model.lambda());
  }
  return vibrating_system(model, alpha, beta, more);
}

// True if the range of the sweep has a mode's frequency in it.
bool crosses_mode(const ResponseOptions& options, const Model& model) {
  const double low = std::min(options.from, options.to), high = std::max(options.from, options.to);
  const Eigen::VectorXd frequencies = model.frequencies_hz();
  return std::any_of(frequencies.begin(), frequencies.end(),
                     [&](double frequency) { return frequency >= low && frequency <= high; });
}

// One curve, with its ending and its seconds.
template <class Trace>
Result<CurveResult> timed(const Trace& trace) {
  CurveResult result;
  const auto start = std::chrono::steady_clock::now();
  const double before = processor_time();
  if (Status s = take(result.curve, trace()); !s) return s.error();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  result.processor_seconds = processor_time() - before;
  return result;
}

// A curve of which not even the first point was found: it is reported, and others go on. where: as
// in "at 1.2 Hz".
CurveResult curve_not_found(const std::string& where, const Error& error) {
  CurveResult result;
  result.curve.end = CurveEnd::kStuck;
  result.exit_code = exit_code(error.kind);
  result.reason = fmt::format("no point was found {}: {}", where, error.message);
  return result;
}

using LoadedAmplitude = std::function<double(const FourierSeries&, double)>;

// The amplitude under `scale` times the load.
LoadedAmplitude at_scale(LoadedAmplitude amplitude, double scale) {
  if (!amplitude) return {};
  return [=](const FourierSeries& motion, double load) { return amplitude(motion, scale * load); };
}

// Of a free body, as `tremolo run` says it.
void note_rigid_motion(const Model& model, CurveResult& result) {
  if (model.rigid_mode_count() == 0) return;
  result.warnings.push_back(fmt::format(
      "a free body: amplitudes are those of its strain, {} motions without strain are left out; a "
      "force F moves a mass m by F/(m omega^2) besides",
      model.rigid_mode_count()));
}

// A response curve and how it was found.
struct Followed {
  const VibratingSystem& system;
  const ResponseRequest& request;
  const CurveOptions& options;
  const PeriodicModel& made;
  bool damped;
  const ProbeResponse& response;  // at the load scale 1
};

Status check_stepping(const ResponseOptions& options, const VibratingSystem& system) {
  if (!options.by_stepping) return Success{};
  if (!options.load_harmonics.empty())
    return usage_error("--by-stepping steps under a sine alone: leave --load-harmonic out");
  if (options.no_stability)
    return usage_error("--by-stepping goes to the stable points: leave --no-stability out");
  if (!system.damped())
    return usage_error(
        "--by-stepping needs a damping, such as --damping-ratio 2%: without it no "
        "motion settles");
  return Success{};
}

// The stable points of the curve by time stepping. The damping has been checked.
Status step_points(const ResponseOptions& options, const PeriodicModel& made,
                   const VibratingSystem& system, const ProbeResponse& response,
                   CurveResult& result) {
  // Few steps show stiff coordinates as slow to settle, which would make the other side wait.
  Floquet floquet(system);
  for (CurvePoint& point : result.curve.points)
    point.multipliers =
        floquet.multipliers(point.motion, point.omega, floquet_steps(point.harmonics()));
  SteppedLoad load{made.model,
                   {},
                   result.load_scale * made.load,
                   made.constant,
                   made.probe_rows,
                   result.load_scale * response.periodic.col(sine_column(1)),
                   response.constant};
  load.damping.alpha = options.alpha;
  load.damping.beta = options.beta;
  if (!options.damping_ratio.empty())
    put_damping(*parse_damping(options.damping_ratio), load.damping);
  return take(result.stepped.emplace(),
              step_curve(load, result.curve, options.to > options.from ? 1.0 : -1.0));
}

// The curves that --folds-to and --branches ask for, from the first response curve.
Status follow(const ResponseOptions& options, const Followed& by, const CurveResult& first,
              std::vector<CurveResult>& more) {
  const auto add = [&](CurveRole role, const Bifurcation& at, const auto& trace) -> Status {
    Result<CurveResult> result = timed(trace);
    const double frequency = at.point.omega / (2.0 * std::numbers::pi);
    const bool found = static_cast<bool>(result);
    if (!found && result.error().kind != ErrorKind::kSolver) return result.error();
    if (!found)
      result = curve_not_found(
          fmt::format("beyond {:.6g} Hz, amplitude {:.4g} m", frequency, at.point.amplitude),
          result.error());
    const bool folds = role == CurveRole::kFolds;
    result->label = fmt::format("{} {:.5g} Hz", folds ? "folds from" : "branch at", frequency);
    result->role = role;
    result->load_scale = first.load_scale;
    const std::string to = folds ? fmt::format("a load scale of {:g}", *options.folds_to)
                                 : std::string("the end of the range");
    if (found) set_ending(by.made, by.damped, to, by.options, *result);
    more.push_back(std::move(*result));
    return Success{};
  };
  for (const Bifurcation& at : first.curve.bifurcations) {
    Status done = Success{};
    if (options.folds_to && at.kind == BifurcationKind::kFold)
      done = add(CurveRole::kFolds, at, [&] {
        return fold_curve(by.system, by.request, at.point, *options.folds_to / first.load_scale,
                          by.options);
      });
    for (const int sign : {1, -1})
      if (done && options.branches && at.kind == BifurcationKind::kBranch)
        done = add(CurveRole::kBranch, at, [&] {
          return crossing_branch(by.system, by.request, first.curve, at.point, sign, by.options);
        });
    if (!done) return done;
  }
  return Success{};
}

// A curve that a signal ended.
void note_signal(const Interruption& interruption, CurveResult& result) {
  if (result.curve.end != CurveEnd::kStopped) return;
  result.exit_code = 128 + interruption.signal();
  result.reason = fmt::format("ended by signal {}", interruption.signal());
}

// The response curve at one load, also if no point of it was found.
Result<CurveResult> response_at(const ResponseOptions& options, const Followed& by, double scale,
                                const Interruption& interruption) {
  Result<CurveResult> result =
      timed([&] { return response_curve(by.system, by.request, by.options); });
  const bool found = static_cast<bool>(result);
  if (!found && result.error().kind != ErrorKind::kSolver) return result.error();
  if (!found) result = curve_not_found(fmt::format("at {:g} Hz", options.from), result.error());
  result->label = fmt::format("load x {:g}", scale);
  result->load_scale = scale;
  if (!found) return result;
  // The truncated equations may pass a resonance that nothing bounds.
  if (!by.damped && crosses_mode(options, *by.made.model) &&
      result->curve.end != CurveEnd::kStopped)
    result->curve.end = CurveEnd::kUnbounded;
  set_ending(by.made, by.damped, fmt::format("{:g} Hz", options.to), by.options, *result);
  note_signal(interruption, *result);
  note_rigid_motion(*by.made.model, *result);
  if (!options.by_stepping || interruption.signal() != 0) return result;
  if (Status s = step_points(options, by.made, by.system, by.response, *result); !s) {
    result->stepped.reset();
    result->exit_code = exit_code(s.error().kind);
    result->reason +=
        (result->reason.empty() ? "" : "; ") + ("--by-stepping: " + s.error().message);
  }
  return result;
}

}  // namespace

int response_command(const ResponseOptions& options) {
  if (Status s = check_frequencies(options); !s) return report_error(s.error());
  const Result<std::vector<double>> scales = load_scales_of(options);
  if (!scales) return report_error(scales.error());
  const Result<FourierSeries> course = course_of(options);
  if (!course) return report_error(course.error());
  const PeriodicFiles files(options, "response");
  const std::vector<NamedFile> inputs = inputs_of(options);
  if (Status s = files.check(options, inputs); !s) return report_error(s.error());
  const GuardedInputs guard(inputs);
  const Result<PeriodicModel> made = periodic_model(options, true, 0);
  if (!made) return report_error(made.error());
  Result<CurveOptions> curve = curve_options(options, *made, kMostHarmonicsOfResponse);
  if (!curve) return report_error(curve.error());
  Result<VibratingSystem> system = system_of(options, *made->model);
  if (!system) return report_error(system.error());
  if (Status s = check_stepping(options, *system); !s) return report_error(s.error());
  if (!system->damped()) limit_undamped(*curve);
  const Interruption interruption;
  curve->stopped = [&] { return interruption.signal() != 0; };
  Eigen::Vector3d direction = made->probe_rows.col(0);
  if (made->load[0] < 0.0) direction = -direction;
  const Result<ProbeResponse> response =
      probe_response(*made->model, made->probe, made->place_forces, *course, options.static_scale);
  if (!response) return report_error(response.error());
  const CurveContext context{
      *made, *system,  direction.normalized(), std::atan2((*course)(0, 1), (*course)(0, 2)), true,
      false, *response};
  std::vector<CurveResult> results, more;
  for (const double scale : *scales) {
    ResponseRequest request{scale * made->load * *course, in_radians(options.from),
                            in_radians(options.to)};
    request.force.col(0) = made->constant;
    curve->loaded_amplitude = at_scale(loaded_amplitude_of(made->the_probe(), *response), scale);
    const Followed followed{*system, request, *curve, *made, system->damped(), *response};
    Result<CurveResult> result = response_at(options, followed, scale, interruption);
    if (!result) return report_error(result.error());
    results.push_back(std::move(*result));
    if (interruption.signal() != 0) break;
    if (results.size() > 1 || results.front().curve.points.empty()) continue;
    if (Status s = follow(options, followed, results.front(), more); !s)
      return report_error(s.error());
  }
  for (CurveResult& result : more) results.push_back(std::move(result));
  Json head = head_of(options, *made);
  head["from_hz"] = options.from;
  head["to_hz"] = options.to;
  head["damping"] = options.damping_ratio.empty() ? Json(nullptr) : Json(options.damping_ratio);
  const std::string subtitle = fmt::format("{}, vertex {}, {:g} to {:g} Hz", options.model,
                                           made->probe, options.from, options.to);
  return finish(options, files, "Response", subtitle, results, context, head);
}

namespace {

// The amplitude in m. Errors: kUsage; kContent if it is not positive.
Result<double> end_amplitude(const std::string& text, double size) {
  std::string_view number = text;
  const bool percent = number.ends_with('%'), metres = number.ends_with('m');
  if (percent || metres) number.remove_suffix(1);
  double value = 0.0;
  const auto [stop, error] = read_decimal(number.data(), number.data() + number.size(), value);
  if (error != std::errc{} || stop != number.data() + number.size())
    return usage_error("--to-amplitude " + text +
                       ": expected a share of the size, as in 10% or 0.1, or a length in m, as in "
                       "0.02m");
  if (!(value > 0.0) || !std::isfinite(value))
    return content_error("--to-amplitude " + text + ": must be positive and finite");
  return metres ? value : percent ? 0.01 * value * size : value * size;
}

}  // namespace

int backbone_command(const BackboneOptions& options) {
  const PeriodicFiles files(options, "backbone");
  const std::vector<NamedFile> inputs = inputs_of(options);
  if (Status s = files.check(options, inputs); !s) return report_error(s.error());
  const GuardedInputs guard(inputs);
  const Eigen::Index mode = options.mode - 1;
  const Result<PeriodicModel> made = periodic_model(options, options.damped, mode);
  if (!made) return report_error(made.error());
  const Result<double> amplitude = end_amplitude(options.to_amplitude, made->size);
  if (!amplitude) return report_error(amplitude.error());
  Result<CurveOptions> curve = curve_options(options, *made, kMostHarmonicsOfBackbone);
  if (!curve) return report_error(curve.error());
  curve->largest_amplitude = std::max(curve->largest_amplitude, 1.01 * *amplitude);
  const Result<VibratingSystem> system =
      options.damped ? system_of(options, *made->model) : vibrating_system(*made->model, 0.0, 0.0);
  if (!system) return report_error(system.error());
  if (options.damped && !system->damped())
    return report_error(usage_error("--damped needs a damping, such as --damping-ratio 2%"));
  if (!options.damped &&
      (options.alpha != 0.0 || options.beta != 0.0 || !options.damping_ratio.empty()))
    return report_error(usage_error(
        "a backbone is the free motion without damping; --damped gives the one with damping"));
  const Interruption interruption;
  curve->stopped = [&] { return interruption.signal() != 0; };
  // The load of a damped backbone is cos(omega t) = sin(omega t + 90 degrees).
  Eigen::Vector3d direction = made->probe_rows.col(mode).normalized();
  if (options.damped && made->load[mode] < 0.0) direction = -direction;
  FourierSeries course = FourierSeries::Zero(1, 3);
  if (options.damped) course(0, cosine_column(1)) = 1.0;
  const Result<ProbeResponse> response =
      probe_response(*made->model, made->probe, made->place_forces, course, options.static_scale);
  if (!response) return report_error(response.error());
  curve->loaded_amplitude = loaded_amplitude_of(made->the_probe(), *response);
  const CurveContext context{*made,          *system,        direction, 0.5 * std::numbers::pi,
                             options.damped, options.damped, *response};
  Result<CurveResult> result = timed([&] {
    return options.damped ? damped_backbone_curve(
                                *system, {mode, made->constant, made->load, *amplitude}, *curve)
                          : backbone_curve(*system, {mode, made->constant, *amplitude}, *curve);
  });
  if (!result) return report_error(result.error());
  result->label = fmt::format("mode {}{}", options.mode, options.damped ? ", damped" : "");
  set_ending(*made, true, fmt::format("{:.4g} m", *amplitude), *curve, *result);
  note_signal(interruption, *result);
  note_rigid_motion(*made->model, *result);
  Json head = head_of(options, *made);
  head["mode"] = options.mode;
  if (options.damped)
    head["damping"] = options.damping_ratio.empty() ? Json(nullptr) : Json(options.damping_ratio);
  head["linear_frequency_hz"] = hertz(made->model->lambda()[mode]);
  head["to_amplitude"] = *amplitude;
  const std::string subtitle = fmt::format("{}, mode {}, vertex {}, to {:.4g} m", options.model,
                                           options.mode, made->probe, *amplitude);
  return finish(options, files, "Backbone", subtitle, {std::move(*result)}, context, head);
}

}  // namespace tremolo
