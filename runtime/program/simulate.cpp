#include "runtime/program/simulate.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/render_writer.h"
#include "formats/surface_writer.h"
#include "runtime/program/energy_bound.h"
#include "runtime/program/plot.h"
#include "runtime/program/recorder.h"
#include "runtime/program/selection.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPicture = "energy.svg";
constexpr std::int64_t kStretchEvery = 10;  // steps; the shape moves by the slow modes

Error usage_error(std::string message) {
  return {ErrorKind::kUsage, std::move(message)};
}

// The library calls a wrong argument wrong usage; on the command line that is an unknown flag or
// name, and a number out of range is an invalid value.
Error value_error(Error error) {
  if (error.kind == ErrorKind::kUsage) error.kind = ErrorKind::kContent;
  return error;
}

Status check(const RunOptions& options) {
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
  if ((options.surfaces > 0 || options.plot) && options.out.empty())
    return usage_error("--surfaces and --plot need --out DIR");
  if (options.at.empty() != options.force.empty())
    return usage_error("--at and --force belong together");
  if (!std::isfinite(options.scale)) return content_error("--scale must be finite");
  return Success{};
}

// --at and --force: on one vertex, or shared by those of a selector.
Result<DefaultLoad> spread_force(const RunOptions& options, const Model& model,
                                 const Eigen::Vector3d& force) {
  VertexId vertex = 0;
  const char* end = options.at.data() + options.at.size();
  const auto [stop, code] = std::from_chars(options.at.data(), end, vertex);
  if (stop == end && code == std::errc{}) {
    if (vertex < 0) return content_error("--at must not be negative");
    return DefaultLoad{{vertex}, {force}};
  }
  const Result<Selection> chosen = select_on_boundary(
      options.at, {model.surface(), model.render(), model.default_load(), model.vertex_count()});
  if (!chosen) return chosen.error();
  for (const std::string& note : chosen->notes) std::fprintf(stderr, "  --at %s\n", note.c_str());
  const Eigen::Vector3d share =
      force / static_cast<double>(std::max<std::size_t>(1, chosen->ids.size()));
  return DefaultLoad{chosen->ids, std::vector<Eigen::Vector3d>(chosen->ids.size(), share)};
}

Status add_load(const RunOptions& options, Body& body) {
  Result<Signal> signal = parse_signal(options.load);
  if (!signal) return signal.error();
  if (signal->kind == SignalKind::kNone) return Success{};
  if (options.at.empty()) {
    if (body.model().default_load().vertices.empty())
      return usage_error(options.model +
                         ": the model has no default load; name one with --at and --force, or "
                         "--load none");
    return body.add_default_load(*signal, options.scale);
  }
  Result<Eigen::Vector3d> force = parse_force(options.force);
  if (!force) return force.error();
  const Result<DefaultLoad> load = spread_force(options, body.model(), *force);
  if (!load) return load.error();
  Result<Eigen::VectorXd> reduced = reduce_load(body.model(), *load, options.scale);
  if (!reduced) return value_error(reduced.error());
  if (options.scale != 0.0 && reduced->isZero(0.0))
    return content_error("--at " + options.at +
                         ": no vertex there moves (they are fixed or belong to no tetrahedron), or "
                         "the force is zero");
  return body.add_load({*signal, std::move(*reduced)});
}

Result<Body> make_body(const RunOptions& options) {
  const auto names = integrator_names();
  if (std::find(names.begin(), names.end(), options.integrator) == names.end())
    return usage_error(fmt::format("unknown integrator '{}'; there are {}", options.integrator,
                                   fmt::join(names, ", ")));
  Result<Model::Pointer> model =
      Model::load(options.model, {options.modes, options.linear, options.hull});
  if (!model) return value_error(model.error());
  IntegratorOptions settings;
  settings.step = options.step;
  settings.alpha = options.alpha;
  settings.beta = options.beta;
  settings.newmark_beta = options.newmark_beta;
  settings.newmark_gamma = options.newmark_gamma;
  settings.tolerance = options.tolerance;
  settings.max_iterations = options.max_iterations;
  Result<SplitOptions> split = parse_split(options.split);
  if (!split) return split.error();
  settings.split = *split;
  settings.split.safety = options.safety;
  Result<Body> body = Body::create(*model, options.integrator, settings);
  if (!body) return value_error(body.error());
  if (Status status = add_load(options, *body); !status) return status.error();
  return body;
}

// The author's surface where the body is now.
Status write_render_shape(const Body& body, const std::string& path) {
  RenderSurface surface = body.model().render()->surface;
  const std::size_t count = 3 * surface.vertices.size();
  surface.normals.resize(surface.vertices.size());
  std::vector<float> positions(count);  // of the normals; those that are written are exact
  const Status normals = body.surface(positions, std::span(surface.normals[0].data(), count));
  if (!normals) return normals;
  const Status exact = body.surface_positions(std::span<double>(surface.vertices[0].data(), count));
  if (!exact) return exact;
  return write_render_surface(path, surface);
}

Status write_shape(const Body& body, const std::string& path) {
  if (body.model().render() != nullptr) return write_render_shape(body, path);
  SurfaceMesh surface;
  surface.vertices.resize(body.model().surface().vertex_ids.size());
  surface.triangles = body.model().triangles();
  // Eigen's fixed vectors lie in memory without gaps.
  const std::span<double> flat(surface.vertices.empty() ? nullptr : surface.vertices[0].data(),
                               3 * surface.vertices.size());
  if (Status status = body.surface_positions(flat); !status) return status;
  return write_surface(path, surface);
}

// "surface-0012.ply", as write_due_surface() calls it.
bool is_surface_name(const std::string& name) {
  constexpr std::string_view kStart = "surface-";
  const std::size_t dot = name.find('.');
  if (!name.starts_with(kStart) || dot == std::string::npos || dot < kStart.size() + 4)
    return false;
  const std::string_view ending = std::string_view(name).substr(dot);
  return std::all_of(name.begin() + kStart.size(), name.begin() + static_cast<std::ptrdiff_t>(dot),
                     [](char c) { return c >= '0' && c <= '9'; }) &&
         (ending == ".ply" || ending == ".obj" || ending == ".inc");
}

// Surfaces and picture of an earlier run into the same folder do not belong to this one.
Status remove_leftovers(const std::string& folder, const std::vector<std::string>& written) {
  std::error_code error, ignored;
  std::vector<fs::path> old;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    if ((is_surface_name(name) || name == kPicture) && at->is_regular_file(ignored) &&
        std::find(written.begin(), written.end(), (fs::path(folder) / name).string()) ==
            written.end())
      old.push_back(at->path());
  }
  for (const fs::path& path : old)
    if (!error) fs::remove(path, error);
  if (error) return system_error(folder + ": cannot remove old surfaces: " + error.message());
  return Success{};
}

// Everything that is watched and written while a body runs.
class Watch {
 public:
  Watch(const RunOptions& options, Recorder recorder, std::int64_t steps)
      : options_(options), recorder_(std::move(recorder)), total_steps_(steps) {}

  // After the start and after every step. Returns false when the orbit has left its bound.
  Result<bool> observe(const Body& body, RunReport& report) {
    const Energy energy = body.energy();
    const bool loaded = body.load_to_come();
    drift_.observe(energy.total(), body.work(), body.dissipated(), loaded);
    if (body.steps() == 0) report.energy_initial = energy.total();
    if (loaded || body.steps() == 0 || was_loaded_) report.energy_reference = energy.total();
    was_loaded_ = loaded;
    report.energy_final = energy.total();
    report.high_band_final = energy.high_band;
    if (!options_.out.empty() && body.steps() % options_.every == 0) recorder_.record(body, energy);
    if (Status status = write_due_surface(body, report); !status) return status.error();
    return bound_.holds(body.steps(), energy.total(), body.work());
  }

  Status finish(RunReport& report) {
    report.energy_drift_max = drift_.worst();
    if (options_.out.empty()) return Success{};
    const std::string csv = (fs::path(options_.out) / "run.csv").string();
    if (Status status = recorder_.write(csv); !status) return status;
    report.files.push_back(csv);
    if (options_.plot) {
      const std::string picture = (fs::path(options_.out) / kPicture).string();
      if (Status status = plot_energies({{options_.integrator, csv}}, picture); !status)
        return status;
      report.files.push_back(picture);
    }
    return remove_leftovers(options_.out, report.files);
  }

 private:
  Status write_due_surface(const Body& body, RunReport& report) {
    if (surfaces_written_ >= options_.surfaces) return Success{};
    const auto due = static_cast<std::int64_t>(std::llround(
        static_cast<double>(total_steps_) * (surfaces_written_ + 1) / options_.surfaces));
    if (body.steps() < due) return Success{};
    const std::string path =
        (fs::path(options_.out) /
         fmt::format("surface-{:04}.{}", surfaces_written_, options_.surface_format))
            .string();
    ++surfaces_written_;
    report.files.push_back(path);
    return write_shape(body, path);
  }

  const RunOptions& options_;
  Recorder recorder_;
  DriftMeter drift_;
  std::int64_t total_steps_;
  int surfaces_written_ = 0;
  bool was_loaded_ = false;
  EnergyBound bound_;
};

RunReport start_report(const RunOptions& options, const Body& body) {
  RunReport report;
  report.name = options.name;
  report.integrator = options.integrator;
  report.step = options.step;
  report.duration = options.duration;
  report.split = body.integrator().split();
  return report;
}

std::string why_not_converged(double time, const StepReport& step) {
  if (!std::isfinite(step.residual))
    return fmt::format("the step from t = {:.6g} s did not converge: its numbers overflow", time);
  return fmt::format(
      "the step from t = {:.6g} s did not converge: residual {:.3g} after {} iterations", time,
      step.residual, step.iterations);
}

std::string why_out_of_bound(double time, double energy) {
  if (!std::isfinite(energy))
    return fmt::format("at t = {:.6g} s the energy is no longer a finite number", time);
  return fmt::format(
      "at t = {:.6g} s the energy, {:.3g} J, is more than {:g} times all that the load put in",
      time, energy, kEnergyBound);
}

void break_off(RunReport& report, ErrorKind kind, std::string reason) {
  report.exit_code = static_cast<int>(kind);
  report.reason = std::move(reason);
}

}  // namespace

Result<RunReport> simulate(const RunOptions& options) {
  if (Status status = check(options); !status) return status.error();
  Result<Body> created = make_body(options);
  if (!created) return created.error();
  Body& body = *created;
  Result<Recorder> recorder = Recorder::create(body.model(), options.coordinates, options.probes);
  if (!recorder) return value_error(recorder.error());
  if (!options.out.empty()) {
    std::error_code error;
    fs::create_directories(options.out, error);
    if (error) return system_error(options.out + ": cannot create: " + error.message());
  }

  RunReport report = start_report(options, body);
  const auto steps = static_cast<std::int64_t>(std::llround(options.duration / options.step));
  Watch watch(options, std::move(*recorder), steps);
  SurfaceStretch stretch(body.model());
  Eigen::Matrix<double, 3, Eigen::Dynamic> probe;
  if (!options.probes.empty()) probe = body.model().vertex(options.probes.front())->rows;
  Result<bool> inside = watch.observe(body, report);
  std::chrono::steady_clock::duration spent{};
  while (inside && *inside && body.steps() < steps) {
    const std::optional<Split> split = body.integrator().split();
    const double begun = body.time();
    const auto before = std::chrono::steady_clock::now();
    const StepReport step = body.step();
    spent += std::chrono::steady_clock::now() - before;
    if (!step.converged) {
      break_off(report, ErrorKind::kSolver, why_not_converged(body.time(), step));
      break;
    }
    if (split && split->low != body.integrator().split()->low)
      report.moves.push_back({begun, split->low, body.integrator().split()->low});
    inside = watch.observe(body, report);
    if (inside && !*inside)
      break_off(report, ErrorKind::kBound, why_out_of_bound(body.time(), report.energy_final));
    if (body.steps() % kStretchEvery == 0) {
      const StretchRange now = stretch.measure(body);
      report.stretch.smallest = std::min(report.stretch.smallest, now.smallest);
      report.stretch.largest = std::max(report.stretch.largest, now.largest);
      if (report.squeezed_at < 0 && now.smallest < kSofteningStretch)
        report.squeezed_at = body.time();
    }
    if (probe.cols() > 0)
      report.largest_probe = std::max(report.largest_probe, (probe * body.state().q).norm());
  }
  if (!inside) return inside.error();

  report.steps = body.steps();
  report.reached = body.time();
  const double made = static_cast<double>(std::max<std::int64_t>(body.steps(), 1));
  report.iterations_per_step = static_cast<double>(body.iterations()) / made;
  report.microseconds_per_step = std::chrono::duration<double, std::micro>(spent).count() / made;
  report.split = body.integrator().split();
  report.halved_steps = body.halved_steps();
  report.work = body.work();
  report.dissipated = body.dissipated();
  if (Status status = watch.finish(report); !status) return status.error();
  return report;
}

}  // namespace tremolo
