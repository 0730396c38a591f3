#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "common/damping_ratios.h"
#include "common/text.h"
#include "common/units.h"
#include "formats/file/atomic_file.h"
#include "formats/file/output_guard.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/response/curve_report.h"
#include "runtime/apps/tremolo/response/periodic_model.h"
#include "runtime/apps/tremolo/response/response_commands.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/run/run_files.h"
#include "runtime/apps/tremolo/run/run_progress.h"
#include "runtime/response/backbone.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

double in_radians(double frequency) {
  return 2.0 * std::numbers::pi * frequency;
}

// The files that a command writes. name: of those in --out, without ending.
struct PeriodicFiles {
  std::vector<std::string> tables, pages, reports;

  PeriodicFiles(const PeriodicOptions& options, const std::string& name) {
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
    return list;
  }

  // Errors: kUsage if one is an input or another output, or a page is not .html; kSystem.
  Status check(const PeriodicOptions& options, const std::vector<NamedFile>& inputs) const {
    for (const std::string& page : pages)
      if (fs::path(page).extension() != ".html")
        return usage_error("--page " + page + ": curves are drawn on a page, .html");
    if (Status s = keep_apart(all(), inputs); !s) return s;
    if (Status s = check_writable({options.csv, options.page}); !s) return s;
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
  return json;
}

// All curves: at the top if there is only one, else as a list.
Json report_of(Json head, const std::vector<CurveResult>& results, const CurveContext& context,
               const std::vector<std::string>& files) {
  double seconds = 0.0;
  for (const CurveResult& result : results) seconds += result.seconds;
  if (results.size() == 1) {
    if (context.forced) head["load_scale"] = results.front().load_scale;
    head.update(curve_json(results.front(), context));
  } else {
    head["curves"] = Json::array();
    for (const CurveResult& result : results) {
      Json one = {{"load_scale", result.load_scale}};
      one.update(curve_json(result, context));
      head["curves"].push_back(std::move(one));
    }
    head["seconds"] = seconds;
  }
  head["files"] = files;
  return head;
}

// Writes all files, prints the curves and the JSON. The exit code.
int finish(const PeriodicOptions& options, const PeriodicFiles& files, const std::string& title,
           const std::string& subtitle, const std::vector<CurveResult>& results,
           const CurveContext& context, const Json& head) {
  const Json report = report_of(head, results, context, files.all());
  if (!options.out.empty()) {
    std::error_code error;
    fs::create_directories(options.out, error);
  }
  for (const std::string& path : files.tables)
    if (Status s = write_file(path, curve_table(results, context)); !s)
      return report_error(s.error());
  for (const std::string& path : files.pages)
    if (Status s = write_file(path, curve_page(title, subtitle, results, context)); !s)
      return report_error(s.error());
  for (const std::string& path : files.reports)
    if (Status s = write_file(path, json_text(report)); !s) return report_error(s.error());
  int code = 0;
  for (const CurveResult& result : results) {
    print_curve(result, context);
    if (result.exit_code == 0) continue;
    tell("tremolo: {}: {}\n", result.label, result.reason);
    code = result.exit_code;
  }
  if (options.json) print_json(report);
  return flushed(code);
}

struct LoadHarmonic {
  int number = 1;
  double scale = 1.0;
  double phase = 0.0;  // rad
};

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

// The load in time: columns of a series of one row, without the constant part.
Result<FourierSeries> load_course(const ResponseOptions& options) {
  std::vector<LoadHarmonic> parts;
  for (const std::string& text : options.load_harmonics) {
    const Result<LoadHarmonic> part = parse_load_harmonic(text);
    if (!part) return part.error();
    parts.push_back(*part);
  }
  if (parts.empty()) parts.push_back({});
  int most = 1;
  for (const LoadHarmonic& part : parts) most = std::max(most, part.number);
  FourierSeries course = FourierSeries::Zero(1, 2 * most + 1);
  for (const LoadHarmonic& part : parts) {
    course(0, cosine_column(part.number)) += part.scale * std::sin(part.phase);
    course(0, sine_column(part.number)) += part.scale * std::cos(part.phase);
  }
  return course;
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
  for (const double scale : options.load_scales)
    if (!std::isfinite(scale) || scale == 0.0)
      return content_error("--load-scale must be finite and other than zero");
  return Success{};
}

Result<VibratingSystem> system_of(const ResponseOptions& options, const Model& model) {
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
    if (ratios->of_each_mode()) more = modal_rates(*ratios, model.lambda());
  }
  return vibrating_system(model, alpha, beta, more);
}

// Without damping no motion attracts others and a curve need not end: no stability is computed, no
// harmonics are added, and the points are limited.
void limit_undamped(CurveOptions& options) {
  constexpr int kMostPoints = 500;
  options.stability = false;
  options.most_harmonics = options.harmonics;
  options.most_points = std::min(options.most_points, kMostPoints);
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
  if (Status s = take(result.curve, trace()); !s) return s.error();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

// A curve that a signal ended.
void note_signal(const Interruption& interruption, CurveResult& result) {
  if (result.curve.end != CurveEnd::kStopped) return;
  result.exit_code = 128 + interruption.signal();
  result.reason = fmt::format("ended by signal {}", interruption.signal());
}

}  // namespace

int response_command(const ResponseOptions& options) {
  if (Status s = check_frequencies(options); !s) return report_error(s.error());
  const Result<FourierSeries> course = load_course(options);
  if (!course) return report_error(course.error());
  const PeriodicFiles files(options, "response");
  const std::vector<NamedFile> inputs = inputs_of(options);
  if (Status s = files.check(options, inputs); !s) return report_error(s.error());
  const GuardedInputs guard(inputs);
  const Result<PeriodicModel> made = periodic_model(options, true, 0);
  if (!made) return report_error(made.error());
  Result<CurveOptions> curve = curve_options(options, *made);
  if (!curve) return report_error(curve.error());
  Result<VibratingSystem> system = system_of(options, *made->model);
  if (!system) return report_error(system.error());
  if (!system->damped()) limit_undamped(*curve);
  const Interruption interruption;
  curve->stopped = [&] { return interruption.signal() != 0; };
  Eigen::Vector3d direction = made->probe_rows.col(0);
  if (made->load[0] < 0.0) direction = -direction;
  const CurveContext context{*made, *system, direction.normalized(),
                             std::atan2((*course)(0, 1), (*course)(0, 2)), true};
  std::vector<CurveResult> results;
  for (const double scale : options.load_scales) {
    ResponseRequest request{scale * made->load * *course, in_radians(options.from),
                            in_radians(options.to)};
    request.force.col(0) = made->constant;
    Result<CurveResult> result = timed([&] { return response_curve(*system, request, *curve); });
    if (!result) return report_error(result.error());
    result->label = fmt::format("load x {:g}", scale);
    result->load_scale = scale;
    // The truncated equations may pass a resonance that nothing bounds.
    if (!system->damped() && crosses_mode(options, *made->model) &&
        result->curve.end != CurveEnd::kStopped)
      result->curve.end = CurveEnd::kUnbounded;
    set_ending(*made, system->damped(), fmt::format("{:g} Hz", options.to), *curve, *result);
    note_signal(interruption, *result);
    results.push_back(std::move(*result));
    if (interruption.signal() != 0) break;
  }
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
  const Result<PeriodicModel> made = periodic_model(options, false, mode);
  if (!made) return report_error(made.error());
  const Result<double> amplitude = end_amplitude(options.to_amplitude, made->size);
  if (!amplitude) return report_error(amplitude.error());
  Result<CurveOptions> curve = curve_options(options, *made);
  if (!curve) return report_error(curve.error());
  curve->largest_amplitude = std::max(curve->largest_amplitude, 1.01 * *amplitude);
  const Result<VibratingSystem> system = vibrating_system(*made->model, 0.0, 0.0);
  if (!system) return report_error(system.error());
  const Interruption interruption;
  curve->stopped = [&] { return interruption.signal() != 0; };
  const CurveContext context{*made, *system, made->probe_rows.col(mode).normalized(), 0.0, false};
  Result<CurveResult> result = timed([&] {
    return backbone_curve(*system, {mode, made->constant, *amplitude}, *curve);
  });
  if (!result) return report_error(result.error());
  result->label = fmt::format("mode {}", options.mode);
  set_ending(*made, true, fmt::format("{:.4g} m", *amplitude), *curve, *result);
  note_signal(interruption, *result);
  Json head = head_of(options, *made);
  head["mode"] = options.mode;
  head["linear_frequency_hz"] = hertz(made->model->lambda()[mode]);
  head["to_amplitude"] = *amplitude;
  const std::string subtitle = fmt::format("{}, mode {}, vertex {}, to {:.4g} m", options.model,
                                           options.mode, made->probe, *amplitude);
  return finish(options, files, "Backbone", subtitle, {std::move(*result)}, context, head);
}

}  // namespace tremolo
