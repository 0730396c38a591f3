#include "runtime/apps/tremolo/response/periodic_model.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/run/run_options.h"
#include "runtime/apps/tremolo/start/start_state.h"
#include "runtime/load.h"
#include "runtime/place_forces.h"
#include "runtime/response/probe.h"
#include "runtime/scene/selection.h"

namespace tremolo {
namespace {

// The flags in the form of `tremolo run`, so that model and load are made in one way.
Result<BodyScene> scene_of(const PeriodicOptions& options) {
  if (std::filesystem::path(options.model).extension() == ".toml")
    return usage_error(options.model +
                       ": periodic motions are those of one model: name a basis file, not a scene");
  RunOptions run;
  static_cast<LoadedModelOptions&>(run) = options;
  run.load = "constant";
  return body_scene(run);
}

Status set_load(const PeriodicOptions& options, bool needed, PeriodicModel& made) {
  const bool present = !options.at.empty() || !made.model->default_load().vertices.empty();
  made.load = Eigen::VectorXd::Zero(made.model->modes());
  if (!present && !needed && options.static_scale == 0.0) return Success{};
  // Not load_of_run's advice: these commands have no --load.
  if (!present)
    return usage_error(options.model +
                       ": the model has no default load; name one with --at and --force");
  const Result<DefaultLoad> forces = load_of_run(made.scene, *made.model);
  if (!forces) return forces.error();
  Result<Eigen::VectorXd> reduced = reduce_load(*made.model, *forces);
  if (!reduced) return value_error(reduced.error());
  if (reduced->isZero(0.0))
    return content_error(
        (options.at.empty() ? options.model + ": the default load" : "--at " + options.at) +
        ": no vertex there moves (they are fixed or belong to no tetrahedron), or the force is "
        "zero");
  made.load = std::move(*reduced);
  made.place_forces = place_forces_of(*made.model, *forces);
  return Success{};
}

Status set_constant(const PeriodicOptions& options, PeriodicModel& made) {
  made.constant = options.static_scale * made.load;
  if (!made.constant.allFinite()) return content_error("--static-scale must be finite");
  if (options.gravity.empty()) return Success{};
  const Result<Eigen::Vector3d> gravity = parse_force(options.gravity);
  if (!gravity) return usage_error("--gravity " + options.gravity + ": expected X,Y,Z in m/s^2");
  if (made.model->rigid_mode_count() >= 6)
    return content_error("--gravity " + options.gravity + ": " + options.model +
                         " is a free body, which falls and does not sag");
  const InertiaIntegrals* inertia = made.model->inertia();
  if (inertia == nullptr)
    return content_error(options.model +
                         ": --gravity needs the integrals of the mass, which the file does not "
                         "have: make it again with tremolo-precompute");
  made.constant += inertia->linear.topRows(3).transpose() * *gravity;
  return Success{};
}

// Of these vertices the one that moves most in the mode; the rows of all of them if `fixed` is set.
Status set_probe(const PeriodicOptions& options, Eigen::Index mode, PeriodicModel& made) {
  const Model& model = *made.model;
  std::vector<VertexId> vertices = model.surface().vertex_ids;
  if (!options.probe.empty()) {
    const Result<std::vector<VertexId>> named = vertices_of(options.probe, model);
    if (!named) return Error{named.error().kind, "--probe: " + named.error().message};
    vertices = *named;
  }
  Result<Probe> probe = moving_most(model, vertices, mode);
  if (!probe) return value_error(probe.error());
  made.probe = probe->vertex;
  made.probe_rows = std::move(probe->rows);
  if (probe->moves) return Success{};
  return content_error(
      "--probe " + options.probe +
      (vertices.size() == 1 ? ": the vertex is fixed" : ": all vertices are fixed") +
      ": it does not move, so that it has no amplitude");
}

}  // namespace

Result<PeriodicModel> periodic_model(const PeriodicOptions& options, bool needs_load,
                                     Eigen::Index mode) {
  PeriodicModel made;
  if (Status s = take(made.scene, scene_of(options)); !s) return s.error();
  if (Status s = take(made.model, load_model(made.scene)); !s) return s.error();
  if (mode < 0 || mode >= made.model->modes())
    return content_error(
        fmt::format("--mode {}: the model has modes 1 to {}", mode + 1, made.model->modes()));
  made.size = extent_of(*made.model);
  if (!(made.size > 0.0)) return content_error(options.model + ": the surface has no size");
  if (Status s = set_load(options, needs_load, made); !s) return s.error();
  if (Status s = set_constant(options, made); !s) return s.error();
  if (Status s = set_probe(options, mode, made); !s) return s.error();
  return made;
}

Result<CurveOptions> curve_options(const PeriodicOptions& options, const PeriodicModel& made,
                                   Eigen::Index usual_most) {
  constexpr int kMost = 99;
  constexpr double kLargestAmplitude = 1.0;  // relative to the size: no model is valid beyond
  if (options.harmonics < 1 || options.harmonics > kMost)
    return content_error(fmt::format("--harmonics must be from 1 to {}", kMost));
  const int most = options.most_harmonics == 0
                       ? std::max(static_cast<int>(usual_most), options.harmonics)
                       : options.most_harmonics;
  if (most < options.harmonics || most > kMost)
    return content_error(fmt::format("--most-harmonics must be from --harmonics, {}, to {}",
                                     options.harmonics, kMost));
  if (!(options.harmonic_share > 0.0)) return content_error("--harmonic-share must be positive");
  if (!(options.longest_step > 0.0) || options.longest_step > 1.0)
    return content_error("--longest-step must be positive and at most 1");
  if (options.most_points < 2) return content_error("--most-points must be at least 2");
  CurveOptions curve;
  curve.harmonics = options.harmonics;
  curve.most_harmonics = most;
  curve.harmonic_share = options.harmonic_share;
  curve.stability = !options.no_stability;
  curve.most_points = options.most_points;
  curve.longest_step = options.longest_step;
  curve.amplitude = amplitude_of(made.the_probe());
  curve.largest_amplitude = kLargestAmplitude * made.size;
  return curve;
}

}  // namespace tremolo
