#include "runtime/apps/tremolo/run/run_body.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/material.h"
#include "formats/basis/basis_reader.h"
#include "runtime/apps/tremolo/run/sound.h"
#include "runtime/apps/tremolo/start/start_state.h"
#include "runtime/scene/selection.h"

namespace tremolo {
namespace {

Status check_combinations(const RunOptions& options) {
  if ((options.surfaces > 0 || options.plot) && options.out.empty())
    return usage_error("--surfaces and --plot need --out DIR");
  if (options.at.empty() != options.force.empty())
    return usage_error("--at and --force belong together");
  if (options.velocities && options.coordinates.empty() && options.probes.empty())
    return usage_error("--velocities are those of --coordinate and --probe: name some");
  if (options.deflect.empty()) return Success{};
  if (options.scale != 1.0)
    return usage_error("--deflect finds the load's factor: leave --scale out");
  if (options.load == "none" && options.signal.empty())
    return usage_error("--deflect scales a load: there is none");
  if (!options.start.empty() && options.start != "static")
    return usage_error("--deflect scales a load: with --start it works from `static` alone");
  const Result<double> share = parse_share(options.deflect);
  return share ? Status(Success{}) : Status(share.error());
}

Result<Signal> signal_of(const RunOptions& options, const SignalTable& table) {
  if (options.signal.empty()) return shaped_signal(options);
  Signal signal{.kind = SignalKind::kTable, .table = &table};
  if (Status s = shape_signal(options.shape, signal); !s) return s.error();
  return signal;
}

// Reduced and scaled; zero without a load.
Result<Load> reduced_load(const RunOptions& options, const Model& model, const SignalTable& table) {
  Result<Signal> signal = signal_of(options, table);
  if (!signal) return signal.error();
  Load load{*signal, Eigen::VectorXd::Zero(model.modes())};
  if (signal->kind == SignalKind::kNone) return load;
  const Result<DefaultLoad> forces = load_of_run(options, model);
  if (!forces) return forces.error();
  Result<Eigen::VectorXd> reduced = reduce_load(model, *forces, options.scale);
  if (!reduced) return value_error(reduced.error());
  if (!options.at.empty() && options.scale != 0.0 && reduced->isZero(0.0))
    return content_error("--at " + options.at +
                         ": no vertex there moves (they are fixed or belong to no tetrahedron), or "
                         "the force is zero");
  load.force = std::move(*reduced);
  return load;
}

bool read_index(std::string_view text, int& value) {
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && stop == text.data() + text.size() && value >= 0;
}

// A model of another material; it is read as a whole, since all of it changes.
Result<Model::Pointer> load_rescaled(const RunOptions& options) {
  Result<BasisData> data = read_basis(options.model);
  if (!data) return data.error();
  data = rescale_model(std::move(*data), options.rescale, options.model);
  if (!data) return data.error();
  Result<Model::Pointer> model =
      Model::from_data(*data, {options.modes, options.linear, options.hull});
  if (!model) return error_of_file(options.model, value_error(model.error()));
  return model;
}

}  // namespace

Result<Signal> shaped_signal(const RunOptions& options) {
  Result<Signal> signal = parse_signal(options.load);
  if (!signal) return signal;
  if (Status s = shape_signal(options.shape, *signal); !s) return s.error();
  // Without a duration of their own they take the whole run.
  const bool slow = signal->kind == SignalKind::kChirp || signal->kind == SignalKind::kRamp;
  if (slow && !options.shape.duration) signal->duration = options.duration;
  return signal;
}

Error value_error(Error error) {
  if (error.kind == ErrorKind::kUsage) error.kind = ErrorKind::kContent;
  return error;
}

Result<IntegratorOptions> integrator_options(const RunOptions& options) {
  IntegratorOptions settings;
  settings.step = options.step;
  settings.alpha = options.alpha;
  settings.beta = options.beta;
  if (!options.damping_ratio.empty()) {
    const Result<RayleighDamping> damping = parse_damping_ratios(options.damping_ratio);
    if (!damping) return damping.error();
    settings.alpha = damping->alpha;
    settings.beta = damping->beta;
  }
  settings.newmark_beta = options.newmark_beta;
  settings.newmark_gamma = options.newmark_gamma;
  settings.tolerance = options.tolerance;
  settings.max_iterations = options.max_iterations;
  if (Status s = take(settings.split, parse_split(options.split)); !s) return s.error();
  settings.split.safety = options.safety;
  return settings;
}

Status check_run(const RunOptions& options) {
  const auto names = integrator_names();
  if (std::find(names.begin(), names.end(), options.integrator) == names.end())
    return usage_error(fmt::format("unknown integrator '{}'; there are {}", options.integrator,
                                   fmt::join(names, ", ")));
  if (!(options.duration > 0) || !std::isfinite(options.duration))
    return content_error("--duration must be positive and finite (s)");
  if (!(options.step > 0) || !std::isfinite(options.step))
    return content_error("--step must be positive and finite (s)");
  if (options.duration / options.step > 1e12)
    return content_error("--duration and --step ask for more than 1e12 steps");
  if (options.duration < 0.5 * options.step)
    return content_error("--duration is shorter than half a step: nothing would be done");
  const std::string& format = options.surface_format;
  if (format != "ply" && format != "obj" && format != "inc")
    return usage_error("surface-format '" + format + "': must be ply, obj or inc");
  if (options.every < 1) return content_error("--every must be at least 1");
  if (options.surfaces < 0) return content_error("--surfaces must not be negative");
  if (!std::isfinite(options.scale)) return content_error("--scale must be finite");
  if (Status status = check_sound(options.wav, options.step); !status) return status;
  return check_combinations(options);
}

Result<Model::Pointer> load_model(const RunOptions& options) {
  if (!options.rescale.empty()) return load_rescaled(options);
  Result<Model::Pointer> model =
      Model::load(options.model, {options.modes, options.linear, options.hull});
  if (!model) return value_error(model.error());
  return model;
}

Result<DefaultLoad> load_of_run(const RunOptions& options, const Model& model) {
  if (options.signal.empty() && options.load == "none") return DefaultLoad{};
  if (options.at.empty()) {
    if (model.default_load().vertices.empty())
      return usage_error(options.model +
                         ": the model has no default load; name one with --at and --force, or "
                         "--load none");
    return model.default_load();
  }
  const Result<Eigen::Vector3d> force = parse_force(options.force);
  if (!force) return force.error();
  const Result<std::vector<VertexId>> vertices = vertices_of(options.at, model);
  if (!vertices) return Error{vertices.error().kind, "--at: " + vertices.error().message};
  return shared_by_area(*vertices, *force, model);
}

Result<Body> make_body(const RunOptions& options, Model::Pointer model, const SignalTable& table) {
  const Result<IntegratorOptions> settings = integrator_options(options);
  if (!settings) return settings.error();
  Result<Body> body = Body::create(std::move(model), options.integrator, *settings);
  if (!body) return value_error(body.error());
  const Result<Load> load = reduced_load(options, body->model(), table);
  if (!load) return load.error();
  if (load->signal.kind != SignalKind::kNone) {
    Result<DefaultLoad> forces = load_of_run(options, body->model());
    if (!forces) return forces.error();
    for (Eigen::Vector3d& force : forces->forces) force *= options.scale;
    if (Status status = body->add_load(load->signal, *forces); !status)
      return value_error(status.error());
  }
  if (options.start.empty()) return body;
  const double at_start = sample_signal(load->signal, 0.0, options.step).start;
  const Result<State> start = start_state(options.start, body->model(), at_start * load->force);
  if (!start) return start.error();
  if (Status status = body->set_state(start->q, start->p); !status)
    return value_error(status.error());
  return body;
}

Result<Eigen::VectorXd> largest_load(const RunOptions& options, const Model& model,
                                     const SignalTable& table) {
  const Result<Load> load = reduced_load(options, model, table);
  if (!load) return load.error();
  const SignalKind kind = load->signal.kind;
  const bool lasts = kind == SignalKind::kSquare || kind == SignalKind::kSine ||
                     kind == SignalKind::kConstant || kind == SignalKind::kRamp ||
                     kind == SignalKind::kChirp;
  return lasts ? load->force : Eigen::VectorXd(Eigen::VectorXd::Zero(model.modes()));
}

Result<std::vector<int>> coordinates_of(const std::vector<std::string>& texts, Eigen::Index modes) {
  std::vector<int> coordinates;
  for (const std::string& text : texts) {
    int first = 0, last = static_cast<int>(modes) - 1;
    const std::size_t dash = text.find('-', 1);
    const bool good =
        text == "all" || (dash == std::string::npos ? read_index(text, first)
                                                    : read_index(text.substr(0, dash), first) &&
                                                          read_index(text.substr(dash + 1), last));
    if (!good || first > last)
      return usage_error("coordinate '" + text + "': expected a number, a range as in 0-5, or all");
    if (text != "all" && dash == std::string::npos) last = first;
    if (last >= modes)
      return content_error(
          fmt::format("coordinate {}: the model has {}, counted from 0", last, modes));
    for (int i = first; i <= last; ++i)
      if (std::find(coordinates.begin(), coordinates.end(), i) == coordinates.end())
        coordinates.push_back(i);
  }
  return coordinates;
}

Result<std::vector<int>> probes_of(const std::vector<std::string>& texts, const Model& model) {
  std::vector<int> probes;
  for (const std::string& text : texts) {
    const Result<std::vector<VertexId>> vertices = vertices_of(text, model);
    if (!vertices) return Error{vertices.error().kind, "--probe: " + vertices.error().message};
    for (const VertexId id : *vertices)
      if (std::find(probes.begin(), probes.end(), id) == probes.end()) probes.push_back(id);
  }
  return probes;
}

Result<double> parse_share(const std::string& text) {
  const bool percent = text.ends_with('%');
  const char* end = text.data() + text.size() - (percent ? 1 : 0);
  double share = 0.0;
  const auto [stop, error] = std::from_chars(text.data(), end, share);
  if (error != std::errc{} || stop != end)
    return usage_error("--deflect " + text + ": expected a share of the size, as in 5% or 0.05");
  if (percent) share *= 0.01;
  if (!(share > 0) || !std::isfinite(share))
    return content_error("--deflect " + text + ": must be positive and finite");
  return share;
}

}  // namespace tremolo
