#include "runtime/apps/view/live/mode_orbits.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "common/text.h"
#include "runtime/response/backbone.h"
#include "runtime/response/orbit.h"
#include "runtime/response/probe.h"

namespace tremolo {

double ModeOrbits::largest() const {
  double most = 0.0;
  for (const CurvePoint& point : curve.points) most = std::max(most, point.amplitude);
  return most / size;
}

CurvePoint ModeOrbits::at(double share) const {
  return at_amplitude(curve, share * size);
}

Result<ModeOrbits> mode_orbits(const Model& model, Eigen::Index mode,
                               std::function<bool()> stopped) {
  if (mode < 0 || mode >= model.modes())
    return content_error(
        fmt::format("there is no mode {}: the model has modes 1 to {}", mode + 1, model.modes()));
  const Result<Probe> probe = moving_most(model, model.surface().vertex_ids, mode);
  if (!probe) return probe.error();
  const Result<VibratingSystem> system = vibrating_system(model, 0.0, 0.0);
  if (!system) return system.error();
  ModeOrbits orbits;
  orbits.mode = mode;
  orbits.size = extent_of(model);
  orbits.linear_hz = model.frequencies_hz()[mode];
  CurveOptions options;
  options.stability = false;
  options.most_harmonics = 9;
  options.longest_step = 0.05;  // at() interpolates
  options.most_points = 500;
  options.amplitude = amplitude_of(*probe);
  options.largest_amplitude = 2.0 * kLargestOrbit * orbits.size;
  options.stopped = std::move(stopped);
  Result<MotionCurve> curve =
      backbone_curve(*system, {mode, {}, kLargestOrbit * orbits.size}, options);
  if (!curve) return curve.error();
  orbits.curve = std::move(*curve);
  return orbits;
}

Status check_orbit_world(const SceneWorld& world) {
  if (world.size() == 1 && world.body(0).frame() == FrameKind::kFixed &&
      world.scene().guests.empty())
    return Success{};
  return usage_error(
      "--orbit needs a model or a scene of one body whose support does not move: orbits are found "
      "for one body with a fixed support");
}

OrbitFinder::~OrbitFinder() {
  stopped_ = true;
  if (found_.valid()) found_.wait();
}

void OrbitFinder::find(const Model& model, Eigen::Index mode) {
  stopped_ = true;
  if (found_.valid()) found_.wait();
  stopped_ = false;
  found_ = std::async(std::launch::async, [this, &model, mode] {
    return mode_orbits(model, mode, [this] { return stopped_.load(); });
  });
}

std::optional<Result<ModeOrbits>> OrbitFinder::take_found() {
  if (!found_.valid() || found_.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
    return std::nullopt;
  return found_.get();
}

Result<OrbitRequest> parse_orbit_request(const std::string& text) {
  const std::size_t colon = text.find(':');
  const Error wrong =
      usage_error("--orbit " + text + ": expected MODE:AMPLITUDE, as in 1:8% or 2:0.05");
  if (colon == std::string::npos) return wrong;
  std::string_view amplitude = std::string_view(text).substr(colon + 1);
  const bool percent = amplitude.ends_with('%');
  if (percent) amplitude.remove_suffix(1);
  const auto number = [](std::string_view part, double& value) {
    const auto [stop, error] = read_decimal(part.data(), part.data() + part.size(), value);
    return error == std::errc{} && stop == part.data() + part.size();
  };
  double mode = 0.0, share = 0.0;
  if (!number(std::string_view(text).substr(0, colon), mode) || !number(amplitude, share))
    return wrong;
  if (percent) share *= 0.01;
  if (!(mode >= 1.0) || mode > 1e6 || mode != std::floor(mode))
    return content_error("--orbit " + text + ": the mode is a whole number from 1 on");
  if (!(share > 0.0) || share > kLargestOrbit * (1.0 + 1e-12))
    return content_error(
        fmt::format("--orbit {}: the amplitude must be above 0 and at most {:g} % of the size",
                    text, 100.0 * kLargestOrbit));
  return OrbitRequest{static_cast<Eigen::Index>(mode) - 1, share};
}

}  // namespace tremolo
