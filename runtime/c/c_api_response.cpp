// tremolo_response, tremolo_backbone and the curves that follow from one: periodic motion from C.
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "common/text.h"
#include "runtime/bodies/reduced/integrators/solve/damping.h"
#include "runtime/c/c_api_curve.h"
#include "runtime/place_forces.h"
#include "runtime/response/backbone.h"
#include "runtime/response/branches.h"
#include "runtime/response/probe.h"

namespace {

using tremolo::content_error;
using tremolo::CurveEnd;
using tremolo::CurveOptions;
using tremolo::CurvePoint;
using tremolo::FourierSeries;
using tremolo::Model;
using tremolo::MotionCurve;
using tremolo::Probe;
using tremolo::ResponseRequest;
using tremolo::Result;
using tremolo::Status;
using tremolo::Success;
using tremolo::usage_error;
using tremolo::VibratingSystem;

constexpr double kTurn = 2.0 * std::numbers::pi;

// The common parts of both curves.
struct Vibration {
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
  if (given.most_harmonics != 0 &&
      (given.most_harmonics < given.harmonics || given.most_harmonics > kMost))
    return content_error("most_harmonics must be from harmonics to 99, or 0");
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

// The same forces at the places of the model's stored response (place_forces_of).
Eigen::VectorXd place_forces(const tremolo_curve_options& given, const Model& model) {
  if (given.load_vertices == nullptr) return tremolo::place_forces_of(model, model.default_load());
  tremolo::DefaultLoad load;
  for (std::size_t i = 0; i < given.load_count; ++i) {
    load.vertices.push_back(static_cast<tremolo::VertexId>(given.load_vertices[i]));
    load.forces.emplace_back(given.load_forces + 3 * i);
  }
  return tremolo::place_forces_of(model, load);
}

// The constant forces: of gravity, and `load` times static_scale.
Result<Eigen::VectorXd> constant_of(const tremolo_curve_options& given, const Model& model,
                                    const Eigen::VectorXd& load) {
  Eigen::VectorXd constant = given.static_scale * load;
  const Eigen::Vector3d gravity(given.gravity);
  if (gravity.isZero(0.0)) return constant;
  if (model.rigid_mode_count() >= 6)
    return content_error("gravity: a free body falls and does not sag");
  if (model.inertia() == nullptr)
    return content_error(
        "gravity needs the integrals of the mass, which the model does not have: make it again "
        "with tremolo-precompute");
  constant += model.inertia()->linear.topRows(3).transpose() * gravity;
  return constant;
}

Result<Vibration> vibration_of(const Model& model, const tremolo_curve_options& given,
                               Eigen::Index usual_most) {
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
  options.most_harmonics = given.most_harmonics == 0
                               ? std::max<Eigen::Index>(usual_most, given.harmonics)
                               : given.most_harmonics;
  options.harmonic_share = given.harmonic_share;
  options.stability = given.stability != 0;
  options.most_points = given.most_points;
  options.longest_step = given.longest_step;
  options.amplitude = amplitude_of(*probe);
  options.largest_amplitude =
      given.largest_amplitude > 0.0 ? given.largest_amplitude : extent_of(model);
  return Vibration{std::move(*system), std::move(options), std::move(*probe),
                   given.load_scale * *load, std::move(*constant)};
}

// Adds the model's stored response to the amplitude. course: of the load in time.
Status show_response(const Model& model, const tremolo_curve_options& given,
                     const FourierSeries& course, Vibration& made) {
  const Result<tremolo::ProbeResponse> response =
      probe_response(model, made.probe.vertex, given.load_scale * place_forces(given, model),
                     course, given.static_scale / given.load_scale);
  if (!response) return response.error();
  made.options.loaded_amplitude = loaded_amplitude_of(made.probe, *response);
  return Success{};
}

// load_scale: that of a point whose factor of the load is 1.
tremolo_curve_point to_point(const CurvePoint& point, const VibratingSystem& system,
                             double load_scale) {
  return {.frequency_hz = point.omega / kTurn,
          .amplitude = point.amplitude,
          .energy = mean_energy(system, point.motion, point.omega),
          .last_share = point.share,
          .load_scale = load_scale * point.load,
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
    case CurveEnd::kLoop:
      return "it has come back onto one of its own points: a closed loop, onto which a step has "
             "crossed a narrow gap; shorten longest_step";
    case CurveEnd::kCoarse:
      return "the two highest harmonics hold too much for a motion: raise most_harmonics";
    default:
      return "no further point was found, even with the shortest step: raise most_harmonics";
  }
}

// Stores the curve behind a new handle, which also has all parts of `made`.
Status store(tremolo_curve made, Result<MotionCurve> found, tremolo_curve** curve) {
  if (!found) return found.error();
  auto stored = std::make_unique<tremolo_curve>(std::move(made));
  stored->reason = reason_of(found->end);
  for (const CurvePoint& point : found->points)
    stored->points.push_back(to_point(point, stored->system, stored->load_scale));
  for (const tremolo::Bifurcation& one : found->bifurcations)
    stored->bifurcations.push_back(
        {.kind = static_cast<int32_t>(one.kind),
         .reserved = 0,
         .multiplier = {one.multiplier.real(), one.multiplier.imag()},
         .point = to_point(one.point, stored->system, stored->load_scale)});
  stored->curve = std::move(*found);
  *curve = stored.release();
  return Success{};
}

// A curve of this vibration, without its points.
tremolo_curve begin_curve(const Model::Pointer& model, const Vibration& vibration,
                          double load_scale) {
  return {.model = model,
          .system = vibration.system,
          .options = vibration.options,
          .request = {},
          .load_scale = load_scale,
          .probe = vibration.probe.vertex};
}

// The load's course in time, 1 x (2K + 1).
Result<FourierSeries> course_of(const tremolo_curve_options& given) {
  if (given.load_harmonics == nullptr) return tremolo::load_course({});
  if (given.load_harmonic_count == 0)
    return usage_error("load_harmonics needs a load_harmonic_count above 0");
  std::vector<tremolo::LoadHarmonic> parts;
  for (std::size_t i = 0; i < given.load_harmonic_count; ++i) {
    const tremolo_load_harmonic& part = given.load_harmonics[i];
    parts.push_back({part.number, part.scale, part.degrees * kTurn / 360.0});
  }
  return tremolo::load_course(parts);
}

Status need_load(const Vibration& vibration, const tremolo_curve_options& given) {
  if (!vibration.load.isZero(0.0)) return Success{};
  return content_error(given.load_vertices == nullptr
                           ? "the model has no default load that moves it: give load_vertices"
                           : "the load is zero, or acts on fixed vertices alone");
}

Status check_amplitude(double to_amplitude) {
  if (to_amplitude > 0.0 && std::isfinite(to_amplitude)) return Success{};
  return content_error("the amplitude must be positive and finite");
}

// Runs action(model, complete options) -> Status.
template <class Action>
tremolo_status make_curve(const tremolo_model* model, const tremolo_curve_options* options,
                          tremolo_curve** curve, const Action& action) {
  return tremolo::c_api::with(
      model, {{curve, "the place for the curve"}}, [&](const Model&) -> Status {
        const Result<tremolo_curve_options> full = tremolo::c_api::complete(
            options, tremolo_curve_options_init, "tremolo_curve_options_init");
        if (!full) return full.error();
        return action(model->pointer, *full);
      });
}

}  // namespace

static_assert(TREMOLO_CURVE_JOINED == static_cast<int>(CurveEnd::kJoined) &&
              TREMOLO_CURVE_LOOP == static_cast<int>(CurveEnd::kLoop) &&
              TREMOLO_CURVE_COARSE == static_cast<int>(CurveEnd::kCoarse) &&
              TREMOLO_CURVE_LONG == static_cast<int>(CurveEnd::kLong) &&
              TREMOLO_NEIMARK_SACKER == static_cast<int>(tremolo::BifurcationKind::kNeimarkSacker));

void tremolo_curve_options_init(tremolo_curve_options* options) {
  if (options == nullptr) return;
  const CurveOptions defaults;
  *options = {.size = sizeof(tremolo_curve_options),
              .probe = TREMOLO_ANY_VERTEX,
              .mode = 1,
              .harmonics = static_cast<int32_t>(defaults.harmonics),
              .most_harmonics = 0,
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
              .damping_ratio = nullptr,
              .load_harmonics = nullptr,
              .load_harmonic_count = 0};
}

tremolo_status tremolo_response(const tremolo_model* model, const tremolo_curve_options* options,
                                double from_hz, double to_hz, tremolo_curve** curve) {
  return make_curve(
      model, options, curve,
      [&](const Model::Pointer& known, const tremolo_curve_options& full) -> Status {
        Result<Vibration> made = vibration_of(*known, full, tremolo::kMostHarmonicsOfResponse);
        if (!made) return made.error();
        if (Status s = need_load(*made, full); !s) return s;
        const Result<FourierSeries> course = course_of(full);
        if (!course) return course.error();
        if (Status s = show_response(*known, full, *course, *made); !s) return s;
        if (!made->system.damped()) limit_undamped(made->options);
        ResponseRequest request{made->load * *course, kTurn * from_hz, kTurn * to_hz};
        request.force.col(0) = made->constant;
        Result<MotionCurve> found = response_curve(made->system, request, made->options);
        tremolo_curve begun = begin_curve(known, *made, full.load_scale);
        begun.request = std::move(request);
        return store(std::move(begun), std::move(found), curve);
      });
}

tremolo_status tremolo_backbone(const tremolo_model* model, const tremolo_curve_options* options,
                                double to_amplitude, tremolo_curve** curve) {
  return make_curve(
      model, options, curve,
      [&](const Model::Pointer& known, const tremolo_curve_options& full) -> Status {
        if (full.alpha != 0.0 || full.beta != 0.0 || full.damping_ratio != nullptr)
          return content_error(
              "a backbone is the free motion without damping: leave it out, or use "
              "tremolo_damped_backbone");
        if (Status s = check_amplitude(to_amplitude); !s) return s;
        Result<Vibration> made = vibration_of(*known, full, tremolo::kMostHarmonicsOfBackbone);
        if (!made) return made.error();
        if (Status s = show_response(*known, full, FourierSeries::Zero(1, 3), *made); !s) return s;
        made->options.largest_amplitude =
            std::max(made->options.largest_amplitude, 1.01 * to_amplitude);
        return store(begin_curve(known, *made, 0.0),
                     backbone_curve(made->system, {full.mode - 1, made->constant, to_amplitude},
                                    made->options),
                     curve);
      });
}

tremolo_status tremolo_damped_backbone(const tremolo_model* model,
                                       const tremolo_curve_options* options, double to_amplitude,
                                       tremolo_curve** curve) {
  return make_curve(
      model, options, curve,
      [&](const Model::Pointer& known, const tremolo_curve_options& full) -> Status {
        if (full.load_harmonics != nullptr)
          return usage_error("a damped backbone has a load of one harmonic: no load_harmonics");
        if (Status s = check_amplitude(to_amplitude); !s) return s;
        Result<Vibration> made = vibration_of(*known, full, tremolo::kMostHarmonicsOfBackbone);
        if (!made) return made.error();
        if (!made->system.damped())
          return content_error("a damped backbone needs a damping, such as damping_ratio \"2%\"");
        if (Status s = need_load(*made, full); !s) return s;
        FourierSeries cosine = FourierSeries::Zero(1, 3);
        cosine(0, tremolo::cosine_column(1)) = 1.0;
        if (Status s = show_response(*known, full, cosine, *made); !s) return s;
        made->options.largest_amplitude =
            std::max(made->options.largest_amplitude, 1.01 * to_amplitude);
        return store(begin_curve(known, *made, full.load_scale),
                     damped_backbone_curve(
                         made->system, {full.mode - 1, made->constant, made->load, to_amplitude},
                         made->options),
                     curve);
      });
}

namespace {

// Runs action(bifurcation) -> Result<MotionCurve> for one of that kind on a response curve, and
// stores the new curve.
template <class Action>
tremolo_status follow(const tremolo_curve* response, std::size_t index,
                      tremolo::BifurcationKind kind, tremolo_curve** curve, const Action& action) {
  return tremolo::c_api::with_all(
      {{response, "the response"}, {curve, "the place for the curve"}}, [&]() -> Status {
        if (!response->request)
          return usage_error("the curve is not one of tremolo_response: it has no load to change");
        return tremolo::c_api::at_index(
            response->curve.bifurcations, index, "bifurcation",
            [&](const tremolo::Bifurcation& at) -> Status {
              if (at.kind != kind)
                return usage_error("bifurcation " + std::to_string(index) + " is a " +
                                   name_of(at.kind) + ", not a " + name_of(kind));
              tremolo_curve begun{.model = response->model,
                                  .system = response->system,
                                  .options = response->options,
                                  .request = {},
                                  .load_scale = response->load_scale,
                                  .probe = response->probe};
              return store(std::move(begun), action(at), curve);
            });
      });
}

}  // namespace

tremolo_status tremolo_fold_curve(const tremolo_curve* response, size_t bifurcation,
                                  double to_load_scale, tremolo_curve** curve) {
  return follow(response, bifurcation, tremolo::BifurcationKind::kFold, curve,
                [&](const tremolo::Bifurcation& fold) -> Result<MotionCurve> {
                  const double factor = to_load_scale / response->load_scale;
                  if (!(factor > 0.0) || !std::isfinite(factor))
                    return content_error(
                        "to_load_scale must be finite, not zero, and have the sign of the "
                        "response's load_scale");
                  return fold_curve(response->system, *response->request, fold.point, factor,
                                    response->options);
                });
}

tremolo_status tremolo_branch_curve(const tremolo_curve* response, size_t bifurcation,
                                    int32_t direction, tremolo_curve** curve) {
  return follow(response, bifurcation, tremolo::BifurcationKind::kBranch, curve,
                [&](const tremolo::Bifurcation& branch) -> Result<MotionCurve> {
                  if (direction != 1 && direction != -1)
                    return usage_error("the direction of a branch is 1 or -1");
                  return crossing_branch(response->system, *response->request, response->curve,
                                         branch.point, direction, response->options);
                });
}
