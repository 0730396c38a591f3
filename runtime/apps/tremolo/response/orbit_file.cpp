#include "runtime/apps/tremolo/response/orbit_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "common/text.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/io/exchange/animation_writer.h"
#include "runtime/io/exchange/glb_writer.h"
#include "runtime/io/exchange/recording.h"
#include "runtime/io/page/document.h"
#include "runtime/response/orbit.h"

namespace tremolo {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr int kMostFrames = 10000;

const CurvePoint& largest(const MotionCurve& curve) {
  return *std::max_element(
      curve.points.begin(), curve.points.end(),
      [](const CurvePoint& a, const CurvePoint& b) { return a.amplitude < b.amplitude; });
}

// The nearer end of the curve's step across the frequency, of several steps the one with the
// largest amplitude.
Result<CurvePoint> at_frequency(const MotionCurve& curve, double frequency) {
  const double omega = kTurn * frequency;
  const CurvePoint* best = nullptr;
  for (std::size_t i = 0; i + 1 < curve.points.size(); ++i) {
    const CurvePoint &a = curve.points[i], &b = curve.points[i + 1];
    if ((a.omega - omega) * (b.omega - omega) > 0.0) continue;
    const CurvePoint& nearer = std::abs(a.omega - omega) < std::abs(b.omega - omega) ? a : b;
    if (best == nullptr || nearer.amplitude > best->amplitude) best = &nearer;
  }
  if (best != nullptr) return *best;
  const auto [low, high] =
      std::minmax_element(curve.points.begin(), curve.points.end(),
                          [](const auto& a, const auto& b) { return a.omega < b.omega; });
  return content_error(
      fmt::format("--orbit-at {:g}Hz: the curve has frequencies from {:.6g} to "
                  "{:.6g} Hz",
                  frequency, low->omega / kTurn, high->omega / kTurn));
}

// A period of the motion: the last frame is the first one of the next period.
Animation period_of(const Model& model, const CurvePoint& point, int frames, double seconds) {
  Animation animation;
  animation.rate = frames / seconds;
  animation.shapes.push_back(animated_shape(model, "body"));
  AnimatedBody& body = animation.bodies.emplace_back();
  body.name = "body";
  for (int n = 0; n <= frames; ++n) {
    const double part = static_cast<double>(n) / frames;
    const Eigen::VectorXd q = orbit_state(point, kTurn * part).q;
    animation.times.push_back(part * seconds);
    body.q.insert(body.q.end(), q.begin(), q.end());
    body.poses.emplace_back();
  }
  return animation;
}

Result<std::vector<WrittenFile>> write(const std::string& path, const Animation& animation) {
  if (std::filesystem::path(path).extension() != ".html") return write_animation(path, animation);
  const Result<WrittenFile> page = write_motion_page(path, animation);
  if (!page) return page.error();
  return std::vector<WrittenFile>{*page};
}

}  // namespace

Result<OrbitChoice> parse_orbit_choice(std::string_view text) {
  if (text == "peak") return OrbitChoice{};
  if (text == "last") return OrbitChoice{OrbitChoice::Kind::kLast};
  OrbitChoice choice;
  std::string_view number = text;
  if (number.ends_with("Hz")) {
    choice.kind = OrbitChoice::Kind::kFrequency;
    number.remove_suffix(2);
  } else if (number.ends_with('%') || number.ends_with('m')) {
    choice.kind = OrbitChoice::Kind::kAmplitude;
    choice.of_size = number.ends_with('%');
    number.remove_suffix(1);
  }
  const auto [stop, error] =
      read_decimal(number.data(), number.data() + number.size(), choice.value);
  if (choice.kind == OrbitChoice::Kind::kPeak || error != std::errc{} ||
      stop != number.data() + number.size())
    return usage_error("--orbit-at " + std::string(text) +
                       ": expected peak, last, a frequency as in 1.2Hz, or an amplitude as in 8% "
                       "or 0.02m");
  if (!(choice.value > 0.0) || !std::isfinite(choice.value))
    return content_error("--orbit-at " + std::string(text) + ": must be positive and finite");
  if (choice.of_size) choice.value *= 0.01;
  return choice;
}

Result<CurvePoint> chosen_orbit(const OrbitChoice& choice, const MotionCurve& curve, double size) {
  if (curve.points.empty())
    return Error{ErrorKind::kSolver, "--orbit: the first curve has no motion"};
  if (choice.kind == OrbitChoice::Kind::kPeak) return largest(curve);
  if (choice.kind == OrbitChoice::Kind::kLast) return curve.points.back();
  if (choice.kind == OrbitChoice::Kind::kFrequency) return at_frequency(curve, choice.value);
  const double amplitude = choice.of_size ? choice.value * size : choice.value;
  const double most = largest(curve).amplitude;
  // The last point is at the requested amplitude to rounding.
  if (amplitude > most * (1.0 + 1e-9))
    return content_error(
        fmt::format("--orbit-at: the amplitude {:.4g} m is above the curve's largest, {:.4g} m "
                    "({:.3g} % of the size)",
                    amplitude, most, 100.0 * most / size));
  return at_amplitude(curve, amplitude);
}

Status check_orbit_flags(const PeriodicOptions& options) {
  constexpr const char* kEndings[] = {".glb", ".usda", ".pvd", ".pc2",
                                      ".mdd", ".ply",  ".obj", ".html"};
  for (const std::string& path : options.orbit_files)
    if (std::find(std::begin(kEndings), std::end(kEndings),
                  std::filesystem::path(path).extension().string()) == std::end(kEndings))
      return usage_error("--orbit " + path +
                         ": the ending must be .glb, .usda, .pvd, .pc2, .mdd, .ply, .obj or .html");
  if (const Result<OrbitChoice> choice = parse_orbit_choice(options.orbit_at); !choice)
    return choice.error();
  if (options.orbit_files.empty() && options.orbit_at != "peak")
    return usage_error("--orbit-at chooses the motion of a file: name it with --orbit");
  if (options.orbit_frames < 4 || options.orbit_frames > kMostFrames)
    return content_error(fmt::format("--orbit-frames must be from 4 to {}", kMostFrames));
  if (!(options.orbit_seconds >= 0.0) || !std::isfinite(options.orbit_seconds))
    return content_error("--orbit-seconds must be finite and not negative");
  return Success{};
}

Result<Json> write_orbit(const PeriodicOptions& options, const std::vector<CurveResult>& results,
                         const CurveContext& context) {
  if (options.orbit_files.empty()) return Json(nullptr);
  const CurveResult& from = results.front();
  const Result<OrbitChoice> choice = parse_orbit_choice(options.orbit_at);
  if (!choice) return choice.error();
  const Result<CurvePoint> point = chosen_orbit(*choice, from.curve, context.made.size);
  if (!point) return point.error();
  const double period = kTurn / point->omega;
  const double seconds = options.orbit_seconds > 0.0 ? options.orbit_seconds : period;
  const Animation animation = period_of(*context.made.model, *point, options.orbit_frames, seconds);
  Json files = Json::array();
  for (const std::string& path : options.orbit_files) {
    const Result<std::vector<WrittenFile>> written = write(path, animation);
    if (!written) return written.error();
    for (const WrittenFile& file : *written) files.push_back(file.path);
  }
  tell("orbit of {} at {:.6g} Hz, amplitude {:.4g} m ({:.3g} % of the size): {} files, {}\n",
       from.label, point->omega / kTurn, point->amplitude,
       100.0 * point->amplitude / context.made.size, files.size(), options.orbit_files.front());
  return Json{{"frequency_hz", point->omega / kTurn},
              {"amplitude", point->amplitude},
              {"stable", point->multipliers.size() > 0 ? Json(point->stable) : Json(nullptr)},
              {"period", period},
              {"seconds", seconds},
              {"frames", animation.frames()},
              {"files", std::move(files)}};
}

}  // namespace tremolo
