#include "runtime/program/tets/run_tets.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/processor_time.h"
#include "formats/file/output_guard.h"
#include "runtime/program/output/json_values.h"
#include "runtime/program/output/tell.h"
#include "runtime/program/run/interruption.h"
#include "runtime/program/run/run_files.h"
#include "runtime/program/run/run_progress.h"
#include "runtime/program/tets/tets_log.h"
#include "runtime/program/world/scene_ending.h"

namespace tremolo {
namespace {

using TetsJson = nlohmann::ordered_json;

// How a run ended. seconds: processor time of the steps; drawing: of placing the surfaces.
struct TetsEnding : SceneEnding {
  double seconds = 0.0, drawing = 0.0, reached = 0.0;
  std::int64_t steps = 0;
};

TetsJson energies_json(const TetsEnergies& e) {
  return {{"kinetic", number_or_null(e.kinetic)},
          {"elastic", number_or_null(e.elastic)},
          {"gravity", number_or_null(e.gravity)},
          {"total", number_or_null(e.total())}};
}

const char* degree_name(DegreeKind kind) {
  if (kind == DegreeKind::kLinear) return "linear";
  return kind == DegreeKind::kQuadratic ? "quadratic" : "adaptive";
}

TetsJson tets_body_json(const TetSceneBody& wanted, const TetBody& body, const TetsReport& report,
                        const TetContact::Look& contact) {
  return {{"body", wanted.name},
          {"model", wanted.model},
          {"integrator", tet_method_name(wanted.options.method)},
          {"degree", degree_name(wanted.options.degree.kind)},
          {"elements", body.model().elements().size()},
          {"edges", body.model().edges()},
          {"mass", body.model().mass()},
          {"steps", body.steps()},
          {"reached", body.time()},
          {"quadratic_edges_share", number_or_null(report.share)},
          {"edges_switched", report.switched},
          {"energy_of_switches", number_or_null(report.end.switches)},
          {"iterations_per_step", number_or_null(static_cast<double>(report.iterations) /
                                                 static_cast<double>(body.steps()))},
          {"steps_in_parts", report.in_parts},
          {"steps_linearised", report.linearised},
          {"momentum_error", number_or_null(report.momentum_error)},
          {"speed_final", number_or_null(body.momentum().norm() / body.model().mass())},
          {"contact_points_final", contact.touching},
          {"contact_energy_final", number_or_null(contact.energy)},
          {"penetration_final", number_or_null(contact.depth)},
          {"largest_displacement", number_or_null(report.displacement)},
          {"energies_initial", energies_json(report.start)},
          {"energies_final", energies_json(report.end)},
          {"files", report.files}};
}

// One run: bodies, logs, and room for the surfaces.
class TetsRun {
 public:
  TetsRun(const TetScene& scene, TetsBodies bodies, std::vector<TetsLog> logs)
      : scene_(scene), bodies_(std::move(bodies)), logs_(std::move(logs)) {
    vertices_.resize(logs_.size());
    normals_.resize(logs_.size());
    for (std::size_t i = 0; i < logs_.size(); ++i) {
      vertices_[i].resize(bodies_.kind(i).surface->vertices());
      normals_[i].resize(vertices_[i].size());
    }
  }

  Status follow();
  TetsJson json() const;
  void print() const;
  const TetsEnding& ending() const { return ending_; }

 private:
  Status observe(std::size_t i, const TetStepReport& step);
  bool step_all(std::vector<TetStepReport>& steps);
  TetContact::Look contact(std::size_t i) const;

  const TetScene& scene_;
  TetsBodies bodies_;
  std::vector<TetsLog> logs_;
  std::vector<std::vector<Eigen::Vector3d>> vertices_;
  std::vector<std::vector<Eigen::Vector3f>> normals_;
  TetsEnding ending_;
};

Status TetsRun::observe(std::size_t i, const TetStepReport& step) {
  const double before = processor_time();
  bodies_.kind(i).surface->place(bodies_.bodies[i].positions(), vertices_[i], normals_[i]);
  ending_.drawing += processor_time() - before;
  return logs_[i].observe(bodies_.bodies[i], step, vertices_[i], normals_[i]);
}

TetContact::Look TetsRun::contact(std::size_t i) const {
  if (bodies_.contacts.empty()) return {};
  return bodies_.contacts[i].look(bodies_.bodies[i].positions());
}

// False: a step could not be made, and why is known.
bool TetsRun::step_all(std::vector<TetStepReport>& steps) {
  const double before = processor_time();
  for (std::size_t i = 0; i < logs_.size() && ending_.exit_code == 0; ++i) {
    steps[i] = bodies_.bodies[i].step(bodies_.contacts.empty() ? nullptr : &bodies_.contacts[i]);
    if (steps[i].converged) continue;
    ending_.exit_code = exit_code(ErrorKind::kSolver);
    ending_.reason = fmt::format("body '{}': the step from t = {:.6g} s could not be solved",
                                 scene_.bodies[i].name, bodies_.bodies[i].time());
  }
  ending_.seconds += processor_time() - before;
  return ending_.exit_code == 0;
}

Status TetsRun::follow() {
  const Interruption interruption;
  ToldProgress progress(std::filesystem::path(scene_.path).stem().string(), scene_.duration);
  const std::int64_t steps = std::llround(scene_.duration / scene_.step);
  std::vector<TetStepReport> reports(logs_.size());
  for (std::size_t i = 0; i < logs_.size(); ++i)
    if (Status s = observe(i, reports[i]); !s) return s;
  ending_.drawing = 0.0;
  while (ending_.steps < steps && ending_.exit_code == 0 && step_all(reports)) {
    ++ending_.steps;
    ending_.reached = static_cast<double>(ending_.steps) * scene_.step;
    for (std::size_t i = 0; i < logs_.size(); ++i)
      if (Status s = observe(i, reports[i]); !s) return s;
    progress.reached(ending_.reached);
    if (ending_.signal = interruption.signal(); ending_.signal != 0) {
      ending_.exit_code = 128 + ending_.signal;
      ending_.reason = fmt::format("ended at t = {:.6g} s by signal {} ({})", ending_.reached,
                                   ending_.signal, ::strsignal(ending_.signal));
    }
  }
  for (TetsLog& log : logs_)
    if (Status s = log.finish(); !s) return s;
  return Success{};
}

TetsJson TetsRun::json() const {
  const auto steps = static_cast<double>(ending_.steps);
  double share = 0.0, edges = 0.0, momentum = 0.0;
  TetsEnergies start, end;
  for (std::size_t i = 0; i < logs_.size(); ++i) {
    const TetsReport& report = logs_[i].report();
    const auto weight = static_cast<double>(bodies_.bodies[i].model().edges());
    share += weight * report.share;
    edges += weight;
    momentum = std::max(momentum, report.momentum_error);
    for (const auto& [sum, one] : {std::pair{&start, report.start}, {&end, report.end}}) {
      sum->kinetic += one.kinetic;
      sum->elastic += one.elastic;
      sum->gravity += one.gravity;
    }
  }
  TetsJson json;
  json["scene"] = scene_.path;
  json["step"] = scene_.step;
  json["duration"] = scene_.duration;
  json["steps"] = ending_.steps;
  json["reached"] = ending_.reached;
  json["elements"] = bodies_.elements();
  json["quadratic_edges_share"] = number_or_null(share / edges);
  json["microseconds_per_step"] = number_or_null(1e6 * ending_.seconds / steps);
  json["microseconds_per_surface"] = number_or_null(1e6 * ending_.drawing / steps);
  json["frames_per_second"] = number_or_null(steps / (ending_.seconds + ending_.drawing));
  json["real_time_factor"] = number_or_null(scene_.step * steps / ending_.seconds);
  json["memory_bytes"] = bodies_.bytes();
  json["momentum_error"] = number_or_null(momentum);
  json["energies_initial"] = energies_json(start);
  json["energies_final"] = energies_json(end);
  json["exit_code"] = ending_.exit_code;
  json["reason"] = ending_.reason.empty() ? TetsJson(nullptr) : TetsJson(ending_.reason);
  json["bodies"] = TetsJson::array();
  for (std::size_t i = 0; i < logs_.size(); ++i)
    json["bodies"].push_back(
        tets_body_json(scene_.bodies[i], bodies_.bodies[i], logs_[i].report(), contact(i)));
  return json;
}

void TetsRun::print() const {
  tell(
      "{}: {} bodies of {} tetrahedra reached {:.6g} of {:.6g} s in steps of {:.4g} s, {:.0f} us "
      "each\n",
      std::filesystem::path(scene_.path).stem().string(), logs_.size(), bodies_.elements(),
      ending_.reached, scene_.duration, scene_.step,
      1e6 * ending_.seconds / static_cast<double>(ending_.steps));
  for (std::size_t i = 0; i < std::min<std::size_t>(logs_.size(), 12); ++i) {
    const TetsReport& report = logs_[i].report();
    tell(
        "  {} ({}): {:.1f} % of the edges quadratic; energy {:.6g} -> {:.6g} J, {:.2g} J taken by "
        "changes of degree; moved by {:.4g} m at most\n",
        scene_.bodies[i].name, degree_name(scene_.bodies[i].options.degree.kind),
        100.0 * report.share, report.start.total(), report.end.total(), report.end.switches,
        report.displacement);
    if (!report.files.empty()) tell("    wrote {}\n", list_files(report.files));
  }
}

// Refuses a run that would write over its own input.
Status keep_tets_apart(const TetScene& scene) {
  if (scene.outputs.out.empty()) return Success{};
  const std::filesystem::path out(scene.outputs.out);
  std::vector<NamedFile> inputs{{scene.path, "the scene"}};
  std::vector<std::string> outputs{(out / kReportName).string()};
  for (const TetSceneBody& body : scene.bodies) {
    inputs.push_back({body.model, "a file of tetrahedra"});
    outputs.push_back((out / body.name / kTableName).string());
    outputs.push_back((out / body.name / kFramesName).string());
  }
  return keep_apart(outputs, inputs);
}

Result<TetsRun> run_tets(const TetScene& scene) {
  if (Status s = keep_tets_apart(scene); !s) return s.error();
  Result<TetsBodies> bodies = make_tets_bodies(scene);
  if (!bodies) return bodies.error();
  std::vector<TetsLog> logs;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    Result<TetsLog> log = TetsLog::create(scene, bodies->kind(i), i);
    if (!log) return log.error();
    logs.push_back(std::move(*log));
  }
  TetsRun run(scene, std::move(*bodies), std::move(logs));
  if (Status s = run.follow(); !s) return s.error();
  return run;
}

}  // namespace

int run_tets_command(const TetScene& scene, bool json) {
  const Result<TetsRun> run = run_tets(scene);
  if (!run) return report_error(run.error());
  run->print();
  return end_scene_run(scene.outputs, run->json(), run->ending(), json);
}

}  // namespace tremolo
