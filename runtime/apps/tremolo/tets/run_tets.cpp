#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/processor.h"
#include "formats/file/output_guard.h"
#include "runtime/apps/tremolo/measure/tets_log.h"
#include "runtime/apps/tremolo/output/run_progress.h"
#include "runtime/apps/tremolo/output/scene_places.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/output/text_values.h"
#include "runtime/apps/tremolo/run/run_files.h"
#include "runtime/apps/tremolo/run/scene_ending.h"
#include "runtime/apps/tremolo/tets/tets_commands.h"
#include "runtime/bodies/tets/motion/tet_group.h"

namespace tremolo {
namespace {

using TetsJson = nlohmann::ordered_json;

// A clock's seconds in steps, and in placing the surfaces.
struct TetsTimes {
  double steps = 0.0, drawing = 0.0;
  double sum() const { return steps + drawing; }
};

// The end of a run. Times in s.
struct TetsEnding : RunEnding {
  TetsTimes busy, wall;  // processor time of all threads; elapsed time
  double slowest = 0.0;  // the longest elapsed time, per second of motion
  double reached = 0.0;  // simulated
  std::int64_t steps = 0;
};

// Adds the processor time and the elapsed time of a task.
template <class Task>
void take_time(double& busy, double& wall, const Task& task) {
  const double before = clock_seconds(CLOCK_PROCESS_CPUTIME_ID);
  const double begin = clock_seconds(CLOCK_MONOTONIC);
  task();
  busy += clock_seconds(CLOCK_PROCESS_CPUTIME_ID) - before;
  wall += clock_seconds(CLOCK_MONOTONIC) - begin;
}

// first, contact: the contacts at the start and at the end.
TetsJson tets_body_json(const TetSceneBody& wanted, const TetBody& body, const TetsReport& report,
                        const TetContact::Look& first, const TetContact::Look& contact,
                        bool asleep) {
  TetsJson json = tets_report_json(wanted, body, report);
  json["asleep"] = asleep;
  json["contact_points_initial"] = first.touching;
  json["penetration_initial"] = number_or_null(first.depth);
  json["contact_points_final"] = contact.touching;
  json["contact_energy_final"] = number_or_null(contact.energy);
  json["penetration_final"] = number_or_null(contact.depth);
  return json;
}

// One run: bodies, logs, and room for the surfaces.
class TetsRun {
 public:
  TetsRun(const TetScene& scene, TetsBodies bodies, std::vector<TetsLog> logs)
      : scene_(scene), bodies_(std::move(bodies)), logs_(std::move(logs)) {
    vertices_.resize(logs_.size());
    normals_.resize(logs_.size());
    placed_.assign(logs_.size(), 0);
    for (std::size_t i = 0; i < logs_.size(); ++i) {
      sums_.emplace_back(bodies_.group->body(i));
      vertices_[i].resize(bodies_.kind(i).surface->vertices());
      normals_[i].resize(vertices_[i].size());
    }
  }

  Status follow();
  Warnings warnings() const;
  TetsJson json() const;
  void print() const;
  const TetsEnding& ending() const { return ending_; }
  // Paths of all that was written.
  std::vector<std::string> files() const {
    std::vector<std::string> files;
    for (const TetsLog& log : logs_)
      files.insert(files.end(), log.report().files.begin(), log.report().files.end());
    return files;
  }

 private:
  void look_at_start();
  void place_all();
  Status observe_all(const std::vector<TetStepReport>& steps);
  bool step_all(std::vector<TetStepReport>& steps);
  bool inside_bound();
  void note_pace(double second);

  const TetScene& scene_;
  TetsBodies bodies_;
  std::vector<TetsLog> logs_;
  std::vector<TetSums> sums_;  // of each body
  std::vector<std::vector<Eigen::Vector3d>> vertices_;
  std::vector<std::vector<Eigen::Vector3f>> normals_;
  std::vector<TetContact::Look> first_;  // contacts before the first step
  std::vector<std::uint8_t> placed_;     // a surface that sleeps stays as it is
  TetsEnding ending_;
  TetBound bound_;
  double counted_ = 0.0, begun_ = 0.0;  // of the second of motion at hand: wall, s, and its start
};

// Finds contacts at the start: a body that starts in contact is pushed out, with all the energy
// that the contact stores.
void TetsRun::look_at_start() {
  bodies_.group->find_touches();
  for (std::size_t i = 0; i < logs_.size(); ++i) {
    first_.push_back(bodies_.group->contact(i).look());
    if (first_[i].touching == 0) continue;
    tell("{}: body '{}' begins in contact: {} of its points are inside, the deepest by {:.3g} m\n",
         scene_.path, scene_.bodies[i].name, first_[i].touching, first_[i].depth);
  }
}

void TetsRun::place_all() {
  TetGroup& group = *bodies_.group;
  group.pool().run(group.size(), [this, &group](std::size_t i, unsigned) {
    if (placed_[i] != 0 && group.asleep(i)) return;
    bodies_.kind(i).surface->place(group.body(i).positions(), vertices_[i], normals_[i]);
    placed_[i] = group.asleep(i) ? 1 : 0;
  });
}

Status TetsRun::observe_all(const std::vector<TetStepReport>& steps) {
  take_time(ending_.busy.drawing, ending_.wall.drawing, [this] { place_all(); });
  for (std::size_t i = 0; i < logs_.size(); ++i)
    if (Status s = logs_[i].observe(bodies_.group->body(i), steps[i], sums_[i], vertices_[i],
                                    normals_[i], bodies_.group->touched(i));
        !s)
      return s;
  return Success{};
}

// False: a step could not be made, and why is known.
bool TetsRun::step_all(std::vector<TetStepReport>& steps) {
  bool made = true;
  take_time(ending_.busy.steps, ending_.wall.steps, [&] { made = bodies_.group->step(steps); });
  for (std::size_t i = 0; i < logs_.size() && !made && ending_.exit_code == 0; ++i) {
    if (steps[i].converged) continue;
    ending_.exit_code = exit_code(ErrorKind::kSolver);
    ending_.reason = fmt::format("body '{}': the step from t = {:.6g} s could not be solved",
                                 scene_.bodies[i].name, bodies_.group->body(i).time());
  }
  return made;
}

// False: the energy is more than can have been put in, and the ending says so.
bool TetsRun::inside_bound() {
  if (bound_.look(*bodies_.group)) return true;
  ending_.exit_code = exit_code(ErrorKind::kBound);
  const bool bdf2 =
      std::all_of(scene_.bodies.begin(), scene_.bodies.end(),
                  [](const TetSceneBody& body) { return body.options.method == TetMethod::kBdf2; });
  ending_.reason = fmt::format(
      "at t = {:.6g} s the energy of the bodies, {:.3g} J, is more than {:g} times all that was "
      "put in; a shorter step{} or `unsolved = \"cut\"` may help",
      ending_.reached, bound_.energy(), kEnergyBound, bdf2 ? "" : ", `integrator = \"bdf2\"`");
  return false;
}

// The longest second of motion, once it is over.
void TetsRun::note_pace(double reached) {
  if (reached - begun_ < 1.0 - 0.5 * scene_.step) return;
  ending_.slowest = std::max(ending_.slowest, (ending_.wall.sum() - counted_) / (reached - begun_));
  counted_ = ending_.wall.sum();
  begun_ = reached;
}

Status TetsRun::follow() {
  const Interruption interruption;
  ToldProgress progress(std::filesystem::path(scene_.path).stem().string(), scene_.duration);
  const std::int64_t steps = std::llround(scene_.duration / scene_.step);
  std::vector<TetStepReport> reports(logs_.size());
  look_at_start();
  if (Status s = observe_all(reports); !s) return s;
  ending_.busy = ending_.wall = {};
  bool inside = inside_bound();
  while (inside && ending_.steps < steps && ending_.exit_code == 0 && step_all(reports)) {
    ++ending_.steps;
    ending_.reached = static_cast<double>(ending_.steps) * scene_.step;
    for (std::size_t i = 0; i < sums_.size(); ++i) sums_[i].add(bodies_.group->body(i), reports[i]);
    if (Status s = observe_all(reports); !s) return s;
    note_pace(ending_.reached);
    progress.reached(ending_.reached);
    inside = inside_bound();
    if (inside) ending_.interrupted(interruption.signal(), ending_.reached);
  }
  for (TetsLog& log : logs_)
    if (Status s = log.finish(); !s) return s;
  return Success{};
}

Warnings TetsRun::warnings() const {
  constexpr std::int64_t kFewUnsolved = 5;
  Warnings found = keyframe_warnings({}, scene_.colliders);
  std::size_t bodies = 0, worst = 0;
  for (std::size_t i = 0; i < logs_.size(); ++i) {
    const std::int64_t unsolved = logs_[i].report().unsolved;
    if (scene_.bodies[i].options.unsolved == UnsolvedStep::kCut || unsolved <= kFewUnsolved)
      continue;
    ++bodies;
    if (unsolved > logs_[worst].report().unsolved) worst = i;
  }
  if (bodies > 0)
    found.push_back(fmt::format(
        "{} of {} bodies took steps before they were solved, '{}' {} of {}, so that their contact "
        "and friction may be wrong: `unsolved = \"cut\"` solves them, and takes longer",
        bodies, logs_.size(), scene_.bodies[worst].name, logs_[worst].report().unsolved,
        ending_.steps));
  return found;
}

TetsJson TetsRun::json() const {
  const auto steps = static_cast<double>(ending_.steps);
  double share = 0.0, edges = 0.0, momentum = 0.0;
  TetsEnergies start, end;
  for (std::size_t i = 0; i < logs_.size(); ++i) {
    const TetsReport& report = logs_[i].report();
    const auto weight = static_cast<double>(bodies_.group->body(i).model().edges());
    share += weight * report.share;
    edges += weight;
    momentum = std::max(momentum, report.momentum_error());
    for (const auto& [sum, one] : {std::pair{&start, report.start}, {&end, report.end}}) {
      sum->kinetic += one.kinetic;
      sum->elastic += one.elastic;
      sum->gravity += one.gravity;
    }
  }
  TetsJson json;
  json["schema"] = kReportSchema;
  json["scene"] = scene_.path;
  json["step"] = scene_.step;
  json["duration"] = scene_.duration;
  json["steps"] = ending_.steps;
  json["reached"] = ending_.reached;
  json["elements"] = bodies_.elements();
  json["quadratic_edges_share"] = number_or_null(share / edges);
  json["threads"] = scene_.group.threads;
  json["microseconds_per_step"] = number_or_null(1e6 * ending_.busy.steps / steps);
  json["microseconds_per_surface"] = number_or_null(1e6 * ending_.busy.drawing / steps);
  json["frames_per_second"] = number_or_null(steps / ending_.wall.sum());
  json["frames_per_second_slowest"] = number_or_null(1.0 / (ending_.slowest * scene_.step));
  json["real_time_factor"] = number_or_null(scene_.step * steps / ending_.wall.sum());
  json["asleep"] = bodies_.group->sleeping();
  json["energy_of_sleep"] = number_or_null(bodies_.group->energy_of_sleep());
  json["memory_bytes"] = bodies_.bytes();
  json["momentum_error"] = number_or_null(momentum);
  json["energies_initial"] = energies_json(start);
  json["energies_final"] = energies_json(end);
  add_ending(ending_, json);
  json["warnings"] = warnings();
  json["bodies"] = TetsJson::array();
  for (std::size_t i = 0; i < logs_.size(); ++i)
    json["bodies"].push_back(
        tets_body_json(scene_.bodies[i], bodies_.group->body(i), logs_[i].report(), first_[i],
                       bodies_.group->contact(i).look(), bodies_.group->asleep(i)));
  return json;
}

void TetsRun::print() const {
  tell(
      "{}: {} bodies of {} tetrahedra reached {:.6g} of {:.6g} s in steps of {:.4g} s, {:.0f} us "
      "each; {:.1f} frames a second, {:.2f} times real time; {} sleep\n",
      std::filesystem::path(scene_.path).stem().string(), logs_.size(), bodies_.elements(),
      ending_.reached, scene_.duration, scene_.step,
      1e6 * ending_.busy.steps / static_cast<double>(ending_.steps),
      static_cast<double>(ending_.steps) / ending_.wall.sum(),
      scene_.step * static_cast<double>(ending_.steps) / ending_.wall.sum(),
      bodies_.group->sleeping());
  print_warnings(warnings());
  for (std::size_t i = 0; i < std::min<std::size_t>(logs_.size(), 12); ++i) {
    const TetsReport& report = logs_[i].report();
    tell(
        "  {} ({}): {:.1f} % of the edges quadratic; energy {:.6g} -> {:.6g} J, {:.2g} J taken by "
        "changes of degree; moved by {:.4g} m at most\n",
        scene_.bodies[i].name, degree_name(scene_.bodies[i].options.degree.kind),
        100.0 * report.share, report.start.total(), report.end.total(), report.end.switches,
        report.displacement);
    if (report.inverted_most > 0)
      tell("    {} elements were flat or inside out at most, {} are at the end\n",
           report.inverted_most, report.inverted);
    if (!report.files.empty()) tell("    wrote {}\n", list_files(report.files));
  }
}

// Lists the files that a run of the scene writes.
RunOutputs tets_outputs(const TetScene& scene) {
  const std::string& out = scene.outputs.out;
  RunOutputs outputs;
  std::vector<std::string> names;
  for (const TetSceneBody& body : scene.bodies) names.push_back(body.name);
  outputs.add_folder(out, names);
  outputs.add_files(out, {kReportName});
  outputs.add_files(out, names, {kTableName, kFramesName});
  return outputs;
}

Result<SceneRun> run_tets(const TetScene& scene) {
  Result<TetsBodies> bodies = make_tets_bodies(scene);
  if (!bodies) return bodies.error();
  std::vector<TetsLog> logs;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    Result<TetsLog> log = TetsLog::create(scene, bodies->kind(i), i, 0);
    if (!log) return log.error();
    logs.push_back(std::move(*log));
  }
  TetsRun run(scene, std::move(*bodies), std::move(logs));
  if (Status s = run.follow(); !s) return s.error();
  run.print();
  return SceneRun{run.json(), run.ending(), run.files()};
}

}  // namespace

std::vector<NamedFile> inputs_of(const TetScene& scene) {
  std::vector<NamedFile> inputs{{scene.path, "the scene"}};
  for (const TetSceneBody& body : scene.bodies)
    inputs.push_back({body.model, "a file of tetrahedra"});
  for (const std::string& csv : scene.files) inputs.push_back({csv, "a CSV file of the scene"});
  return inputs;
}

int run_tets_command(const TetScene& scene, bool json) {
  return run_scene(inputs_of(scene), tets_outputs(scene), scene.outputs, json,
                   [&] { return run_tets(scene); });
}

}  // namespace tremolo
