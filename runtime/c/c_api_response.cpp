// tremolo_response, tremolo_backbone and tremolo_curve_*: periodic motion from C.
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "common/text.h"
#include "runtime/bodies/reduced/integrators/solve/damping.h"
#include "runtime/c/c_api.h"
#include "runtime/response/backbone.h"
#include "runtime/response/orbit.h"
#include "runtime/response/probe.h"
#include "runtime/response/response.h"

// NOLINTBEGIN(readability-identifier-naming): the name of the C header
struct tremolo_curve {
  tremolo::MotionCurve curve;
  std::vector<tremolo_curve_point> points;
  std::vector<tremolo_bifurcation> bifurcations;
  tremolo::VertexId probe = 0;
  std::string reason;  // empty: as requested
};
// NOLINTEND(readability-identifier-naming)

namespace {

using tremolo::content_error;
using tremolo::CurveEnd;
using tremolo::CurveOptions;
using tremolo::CurvePoint;
using tremolo::Model;
using tremolo::MotionCurve;
using tremolo::Probe;
using tremolo::Result;
using tremolo::Status;
using tremolo::Success;
using tremolo::usage_error;
using tremolo::VibratingSystem;

constexpr double kTurn = 2.0 * std::numbers::pi;

// The common parts of both curves.
struct Vibration {
  const Model& model;
  VibratingSystem system;
  CurveOptions options;
  Probe probe;
  Eigen::VectorXd load;      // reduced, r, with its scale
  Eigen::VectorXd constant;  // r
};

Status check(const tremolo_curve_options& given, const Model& model) {
  constexpr int kMost = 99;
  if (given.mode < 1 || given.mode > model.modes())
    return content_error("mode is " + std::to_string(given.mode) + ": the model has modes 1 to " +
                         std::to_string(model.modes()));
  if (given.harmonics < 1 || given.harmonics > kMost)
    return content_error("harmonics must be from 1 to 99");
  if (given.most_harmonics < given.harmonics || given.most_harmonics > kMost)
    return content_error("most_harmonics must be from harmonics to 99");
  if (given.most_points < 2) return content_error("most_points must be at least 2");
  if (!(given.harmonic_share > 0.0)) return content_error("harmonic_share must be positive");
  if (!(given.longest_step > 0.0) || given.longest_step > 1.0)
    return content_error("longest_step must be positive and at most 1");
  if (!(given.largest_amplitude >= 0.0) || !std::isfinite(given.largest_amplitude))
    return content_error("largest_amplitude must be finite and not negative");
  if (!std::isfinite(given.load_scale) || given.load_scale == 0.0)
    return content_error("load_scale must be finite and other than zero");
  if (!std::isfinite(given.static_scale)) return content_error("static_scale must be finite");
  if (!Eigen::Vector3d(given.gravity).allFinite()) return content_error("gravity must be finite");
  return Success{};
}

Result<Probe> probe_of(const tremolo_curve_options& given, const Model& model) {
  std::vector<tremolo::VertexId> vertices = model.surface().vertex_ids;
  if (given.probe != TREMOLO_ANY_VERTEX) {
    const Result<tremolo::VertexId> vertex = tremolo::c_api::to_vertex(given.probe);
    if (!vertex) return vertex.error();
    vertices = {*vertex};
  }
  Result<Probe> probe = moving_most(model, vertices, given.mode - 1);
  if (probe && !probe->moves)
    return content_error("the probe is fixed: it does not move, so that it has no amplitude");
  return probe;
}

Result<VibratingSystem> system_of(const tremolo_curve_options& given, const Model& model) {
  if (!(given.alpha >= 0.0) || !(given.beta >= 0.0) || !std::isfinite(given.alpha) ||
      !std::isfinite(given.beta))
    return content_error("alpha and beta must be finite and not negative");
  if (given.damping_ratio == nullptr) return vibrating_system(model, given.alpha, given.beta);
  if (given.alpha != 0.0 || given.beta != 0.0)
    return usage_error("damping_ratio gives the damping: leave alpha and beta at 0");
  const Result<tremolo::DampingRatios> ratios = tremolo::parse_damping(given.damping_ratio);
  if (!ratios) return ratios.error();
  if (Status s = check_ratios(*ratios, static_cast<std::size_t>(model.modes())); !s)
    return s.error();
  Eigen::VectorXd more;
  if (ratios->of_each_mode()) more = modal_rates(*ratios, model.lambda());
  return vibrating_system(model, ratios->rayleigh.alpha, ratios->rayleigh.beta, more);
}

// The reduced forces without a scale; zero for a model without a default load.
Result<Eigen::VectorXd> load_of(const tremolo_curve_options& given, const Model& model) {
  if (given.load_vertices == nullptr) {
    if (model.default_load().vertices.empty()) return Eigen::VectorXd::Zero(model.modes()).eval();
    return reduce_load(model, model.default_load());
  }
  if (given.load_forces == nullptr || given.load_count == 0)
    return usage_error("load_vertices needs load_forces and a load_count above 0");
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(model.modes());
  for (std::size_t i = 0; i < given.load_count; ++i) {
    const Result<tremolo::VertexId> vertex = tremolo::c_api::to_vertex(given.load_vertices[i]);
    if (!vertex) return vertex.error();
    const Result<Eigen::VectorXd> force =
        reduce_force(model, *vertex, Eigen::Vector3d(given.load_forces + 3 * i));
    if (!force) return force.error();
    sum += *force;
  }
  return sum;
}

// The constant forces: of gravity, and `load` times static_scale.
Result<Eigen::VectorXd> constant_of(const tremolo_curve_options& given, const Model& model,
                                    const Eigen::VectorXd& load) {
  Eigen::VectorXd constant = given.static_scale * load;
  const Eigen::Vector3d gravity(given.gravity);
  if (gravity.isZero(0.0)) return constant;
  if (model.inertia() == nullptr)
    return content_error(
        "gravity needs the integrals of the mass, which the model does not have: make it again "
        "with tremolo-precompute");
  constant += model.inertia()->linear.topRows(3).transpose() * gravity;
  return constant;
}

Result<Vibration> vibration_of(const Model& model, const tremolo_curve_options& given) {
  if (Status s = check(given, model); !s) return s.error();
  Result<Probe> probe = probe_of(given, model);
  if (!probe) return probe.error();
  Result<VibratingSystem> system = system_of(given, model);
  if (!system) return system.error();
  const Result<Eigen::VectorXd> load = load_of(given, model);
  if (!load) return load.error();
  Result<Eigen::VectorXd> constant = constant_of(given, model, *load);
  if (!constant) return constant.error();
  CurveOptions options;
  options.harmonics = given.harmonics;
  options.most_harmonics = given.most_harmonics;
  options.harmonic_share = given.harmonic_share;
  options.stability = given.stability != 0;
  options.most_points = given.most_points;
  options.longest_step = given.longest_step;
  options.amplitude = amplitude_of(*probe);
  options.largest_amplitude =
      given.largest_amplitude > 0.0 ? given.largest_amplitude : extent_of(model);
  return Vibration{model,
                   std::move(*system),
                   std::move(options),
                   std::move(*probe),
                   given.load_scale * *load,
                   std::move(*constant)};
}

tremolo_curve_point to_point(const CurvePoint& point, const VibratingSystem& system) {
  return {.frequency_hz = point.omega / kTurn,
          .amplitude = point.amplitude,
          .energy = mean_energy(system, point.motion, point.omega),
          .last_share = point.share,
          .stable = point.multipliers.size() == 0 ? -1
                    : point.stable                ? 1
                                                  : 0,
          .harmonics = static_cast<int32_t>(point.harmonics())};
}

const char* reason_of(CurveEnd end) {
  switch (end) {
    case CurveEnd::kDone:
      return "";
    case CurveEnd::kUnbounded:
      return "the amplitude is above largest_amplitude: use a smaller load or more damping";
    case CurveEnd::kReturned:
      return "it turned back and left the range where it had begun";
    case CurveEnd::kLong:
      return "it has most_points points: raise most_points or longest_step";
    case CurveEnd::kJoined:
      return "it has joined the backbone of a mode of twice the frequency";
    default:
      return "no further point was found, even with the shortest step: raise most_harmonics";
  }
}

// Stores the curve behind a new handle.
Status store(const Vibration& vibration, Result<MotionCurve> found, tremolo_curve** curve) {
  if (!found) return found.error();
  auto made = std::make_unique<tremolo_curve>();
  made->probe = vibration.probe.vertex;
  made->reason = reason_of(found->end);
  for (const CurvePoint& point : found->points)
    made->points.push_back(to_point(point, vibration.system));
  for (const tremolo::Bifurcation& one : found->bifurcations)
    made->bifurcations.push_back({.kind = static_cast<int32_t>(one.kind),
                                  .reserved = 0,
                                  .multiplier = {one.multiplier.real(), one.multiplier.imag()},
                                  .point = to_point(one.point, vibration.system)});
  made->curve = std::move(*found);
  *curve = made.release();
  return Success{};
}

// Runs action(model, complete options) -> Status.
template <class Action>
tremolo_status make_curve(const tremolo_model* model, const tremolo_curve_options* options,
                          tremolo_curve** curve, const Action& action) {
  return tremolo::c_api::with(
      model, {{curve, "the place for the curve"}}, [&](const Model& known) -> Status {
        const Result<tremolo_curve_options> full = tremolo::c_api::complete(
            options, tremolo_curve_options_init, "tremolo_curve_options_init");
        if (!full) return full.error();
        return action(known, *full);
      });
}

// Runs action(number `index` of the list) -> Status.
template <class List, class Action>
Status at_index(const List& list, std::size_t index, const char* what, const Action& action) {
  if (index < list.size()) return action(list[index]);
  return usage_error("the curve has no " + std::string(what) + " " + std::to_string(index) +
                     ": it has " + std::to_string(list.size()));
}

}  // namespace

static_assert(TREMOLO_CURVE_JOINED == static_cast<int>(CurveEnd::kJoined) &&
              TREMOLO_CURVE_LONG == static_cast<int>(CurveEnd::kLong) &&
              TREMOLO_NEIMARK_SACKER == static_cast<int>(tremolo::BifurcationKind::kNeimarkSacker));

void tremolo_curve_options_init(tremolo_curve_options* options) {
  if (options == nullptr) return;
  const CurveOptions defaults;
  *options = {.size = sizeof(tremolo_curve_options),
              .probe = TREMOLO_ANY_VERTEX,
              .mode = 1,
              .harmonics = static_cast<int32_t>(defaults.harmonics),
              .most_harmonics = static_cast<int32_t>(defaults.most_harmonics),
              .most_points = defaults.most_points,
              .stability = 1,
              .reserved = 0,
              .harmonic_share = defaults.harmonic_share,
              .longest_step = defaults.longest_step,
              .largest_amplitude = 0.0,
              .gravity = {0.0, 0.0, 0.0},
              .load_scale = 1.0,
              .static_scale = 0.0,
              .load_vertices = nullptr,
              .load_forces = nullptr,
              .load_count = 0,
              .alpha = 0.0,
              .beta = 0.0,
              .damping_ratio = nullptr};
}

tremolo_status tremolo_response(const tremolo_model* model, const tremolo_curve_options* options,
                                double from_hz, double to_hz, tremolo_curve** curve) {
  return make_curve(
      model, options, curve, [&](const Model& known, const tremolo_curve_options& full) -> Status {
        Result<Vibration> made = vibration_of(known, full);
        if (!made) return made.error();
        if (made->load.isZero(0.0))
          return content_error(
              full.load_vertices == nullptr
                  ? "the model has no default load that moves it: give load_vertices"
                  : "the load is zero, or acts on fixed vertices alone");
        if (!made->system.damped()) limit_undamped(made->options);
        tremolo::ResponseRequest request;
        request.force = tremolo::FourierSeries::Zero(known.modes(), 3);
        request.force.col(0) = made->constant;
        request.force.col(tremolo::sine_column(1)) = made->load;
        request.omega_from = kTurn * from_hz;
        request.omega_to = kTurn * to_hz;
        return store(*made, response_curve(made->system, request, made->options), curve);
      });
}

tremolo_status tremolo_backbone(const tremolo_model* model, const tremolo_curve_options* options,
                                double to_amplitude, tremolo_curve** curve) {
  return make_curve(
      model, options, curve, [&](const Model& known, const tremolo_curve_options& full) -> Status {
        if (full.alpha != 0.0 || full.beta != 0.0 || full.damping_ratio != nullptr)
          return content_error("a backbone is the free motion without damping: leave it out");
        if (!(to_amplitude > 0.0) || !std::isfinite(to_amplitude))
          return content_error("the amplitude must be positive and finite");
        Result<Vibration> made = vibration_of(known, full);
        if (!made) return made.error();
        made->options.largest_amplitude =
            std::max(made->options.largest_amplitude, 1.01 * to_amplitude);
        return store(*made,
                     backbone_curve(made->system, {full.mode - 1, made->constant, to_amplitude},
                                    made->options),
                     curve);
      });
}

void tremolo_curve_destroy(tremolo_curve* curve) {
  delete curve;
}

size_t tremolo_curve_points(const tremolo_curve* curve) {
  return curve == nullptr ? 0 : curve->points.size();
}

size_t tremolo_curve_bifurcations(const tremolo_curve* curve) {
  return curve == nullptr ? 0 : curve->bifurcations.size();
}

uint32_t tremolo_curve_probe(const tremolo_curve* curve) {
  return curve == nullptr ? TREMOLO_ANY_VERTEX : static_cast<uint32_t>(curve->probe);
}

tremolo_curve_end tremolo_curve_reached(const tremolo_curve* curve) {
  return curve == nullptr ? TREMOLO_CURVE_STUCK : static_cast<tremolo_curve_end>(curve->curve.end);
}

const char* tremolo_curve_reason(const tremolo_curve* curve) {
  return curve == nullptr ? "the curve is NULL" : curve->reason.c_str();
}

tremolo_status tremolo_curve_point_at(const tremolo_curve* curve, size_t index,
                                      tremolo_curve_point* point) {
  return tremolo::c_api::with_all({{curve, "the curve"}, {point, "the place for the point"}}, [&] {
    return at_index(curve->points, index, "point", [&](const tremolo_curve_point& at) -> Status {
      *point = at;
      return Success{};
    });
  });
}

tremolo_status tremolo_curve_bifurcation_at(const tremolo_curve* curve, size_t index,
                                            tremolo_bifurcation* bifurcation) {
  return tremolo::c_api::with_all(
      {{curve, "the curve"}, {bifurcation, "the place for the bifurcation"}}, [&] {
        return at_index(curve->bifurcations, index, "bifurcation",
                        [&](const tremolo_bifurcation& at) -> Status {
                          *bifurcation = at;
                          return Success{};
                        });
      });
}

tremolo_status tremolo_curve_motion(const tremolo_curve* curve, size_t index, double* out,
                                    size_t length) {
  return tremolo::c_api::with_all({{curve, "the curve"}, {out, "the buffer"}}, [&] {
    return at_index(curve->curve.points, index, "point", [&](const CurvePoint& at) -> Status {
      const auto needed = static_cast<std::size_t>(at.motion.size());
      if (Status s = tremolo::c_api::need_buffer(out, length, needed); !s) return s;
      std::copy_n(at.motion.data(), needed, out);
      return Success{};
    });
  });
}

tremolo_status tremolo_curve_state(const tremolo_curve* curve, size_t index, double fraction,
                                   double* q, double* p, size_t length) {
  return tremolo::c_api::with_all({{curve, "the curve"}, {q, "the buffer"}}, [&] {
    return at_index(curve->curve.points, index, "point", [&](const CurvePoint& at) -> Status {
      if (!std::isfinite(fraction)) return usage_error("the fraction of the period is not finite");
      return tremolo::c_api::copy_state(orbit_state(at, kTurn * fraction), q, p, length);
    });
  });
}
