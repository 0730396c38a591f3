#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/file/atomic_file.h"
#include "runtime/apps/tremolo/output/plot.h"
#include "runtime/apps/tremolo/output/run_progress.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/output/world_sound.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/run/run_files.h"
#include "runtime/apps/tremolo/start/run_notes.h"
#include "runtime/apps/tremolo/world/body_log.h"
#include "runtime/apps/tremolo/world/guest_report.h"
#include "runtime/apps/tremolo/world/guest_runs.h"
#include "runtime/apps/tremolo/world/world_commands.h"
#include "runtime/apps/tremolo/world/world_momentum.h"
#include "runtime/apps/tremolo/world/world_report.h"
#include "runtime/world/world_guests.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

// Lists the files that a run of the scene writes.
RunOutputs outputs_of(const MixedFile& mixed) {
  const SceneFile& file = mixed.file;
  const std::string& out = file.outputs.out;
  RunOutputs outputs;
  outputs.add(file.outputs.save);
  outputs.add(file.outputs.wav);
  std::vector<std::string> names;
  for (const SceneBody& body : file.scene.bodies) names.push_back(body.name);
  for (const std::string& name : guest_names(mixed)) names.push_back(name);
  outputs.add_folder(out, names);
  outputs.add_files(out, {kReportName});
  const auto guests = names.begin() + static_cast<std::ptrdiff_t>(file.scene.bodies.size());
  outputs.add_files(out, {names.begin(), guests}, body_files());
  outputs.add_files(out, {guests, names.end()}, {kTableName, kFramesName});
  return outputs;
}

// All that a run of a world measures and writes.
struct WorldRun : WorldWatch {
  std::vector<BodyLog> logs;
  GuestRuns guests;
  std::optional<WorldSound> sound;  // of --wav
  WorldMomentum momentum;
  JointStretch joints;

  Status look(const SceneWorld& world, std::span<const SceneWorld::Failure> failures,
              WorldEnding& ending) override;
  // Takes the ending of the first body that has one.
  void end(WorldEnding& ending) const;
  // Names all bodies whose step failed: any of them may be the cause.
  void name_failed(std::span<const SceneWorld::Failure> failures, WorldEnding& ending) const;
};

Status WorldRun::look(const SceneWorld& world, std::span<const SceneWorld::Failure> failures,
                      WorldEnding& ending) {
  for (const auto& [body, report] : failures) logs[body].give_up(report, world.body(body).time());
  for (std::size_t i = 0; i < logs.size(); ++i)
    if (!world.failed(i))
      if (Status s = logs[i].observe(world); !s) return s;
  if (Status s = guests.observe(); !s) return s;
  momentum.observe(world, guests.guests());
  joints.observe(world);
  if (sound)
    sound->add(world.steps(), [&world](std::size_t i) -> const Eigen::VectorXd& {
      return world.body(i).state().q;
    });
  const bool ended_before = ending.exit_code != 0;
  end(ending);
  guests.ended(ending);
  if (!ended_before) name_failed(failures, ending);
  return Success{};
}

void WorldRun::name_failed(std::span<const SceneWorld::Failure> failures,
                           WorldEnding& ending) const {
  std::string names;
  int count = 0;
  const auto add = [&](const std::string& name) {
    names += (names.empty() ? "'" : ", '") + name + "'";
    ++count;
  };
  for (const auto& [body, report] : failures) add(logs[body].report().name);
  for (std::size_t i = 0; guests.guests() != nullptr && i < guests.guests()->size(); ++i)
    if (guests.guests()->failed(i)) add(guests.guests()->name(i));
  if (ending.exit_code != exit_code(ErrorKind::kSolver) || count == 0) return;
  if (const std::size_t end = ending.reason.find("': "); count > 1 && end != std::string::npos)
    ending.reason = "bodies " + names + ": " + ending.reason.substr(end + 3);
  ending.reason += guests.inverted_text();
}

void WorldRun::end(WorldEnding& ending) const {
  for (const BodyLog& log : logs) ending.take(log.report().name, log.report());
}

// Prints each note once, for the first body that has it.
void take_notes(const SceneFile& file, const SceneWorld& world, WorldRun& run) {
  std::vector<std::string> printed;
  for (std::size_t i = 0; i < run.logs.size(); ++i) {
    const ContactBody& body = world.body(i);
    std::vector<std::string> notes =
        notes_before(body, Eigen::VectorXd::Zero(body.model().modes()));
    if (world.begins_within(i) > 0.0)
      notes.push_back(fmt::format(
          "it begins {:.3g} m within its contact-margin of a collider: its contact begins where it "
          "is, without energy",
          world.begins_within(i)));
    if (body.model().modes() == 0 && !world.scene().bodies[i].columns.coordinates.empty())
      notes.push_back("it is rigid and has no coordinates to record");
    if (run.sound && run.sound->leaves_out(i))
      notes.push_back("it is rigid and makes no sound: it is not listened to");
    for (const std::string& note : notes) {
      if (std::find(printed.begin(), printed.end(), note) != printed.end()) continue;
      printed.push_back(note);
      tell("{}: note: {}\n", file.scene.bodies[i].name, note);
    }
    run.logs[i].add_notes(notes);
  }
}

// Creates the world. If --wav is given without a step, the step of `file` is divided so that its
// modes are accurate.
Result<SceneWorld> make_world(SceneFile& file, bool guests) {
  Result<SceneWorld> world = SceneWorld::create(file.scene, load_scene_model, guests);
  if (!world || file.outputs.wav.empty() || file.outputs.sound_steps > 0) return world;
  file.outputs.sound_steps = steps_a_sample(*world);
  if (file.outputs.sound_steps == 1) return world;
  file.scene.step /= file.outputs.sound_steps;
  const auto known = [&world](const SceneBody& body) {
    return Result<Model::Pointer>(world->body(*world->find(body.name)).model().shared_from_this());
  };
  return SceneWorld::create(file.scene, known, guests);
}

Result<WorldEnding> follow_scene(const SceneFile& file, unsigned threads, SceneWorld& world,
                                 WorldRun& run) {
  const Interruption interruption;
  ToldProgress progress(fs::path(file.path).stem().string(), file.scene.duration);
  return follow(world, {file.scene.duration, 1, threads, &progress, &interruption}, run);
}

// Prints the run.
SceneRun report_of(const SceneFile& file, const SceneWorld& world, const WorldRun& run,
                   const WorldEnding& ending) {
  tell("{}: {} bodies reached {:.6g} of {:.6g} s in steps of {:.4g} s, {:.2f} us each\n",
       fs::path(file.path).stem().string(), world.size() + run.guests.size(), world.time(),
       file.scene.duration, world.step_size(),
       1e6 * ending.seconds / static_cast<double>(ending.steps));
  print_bodies(file, world, run.logs);
  run.guests.print();
  Warnings warnings = world_warnings(file.scene, world);
  add_sheet_warnings(run.guests.json(), warnings);
  run.joints.add_warnings(world, warnings);
  if (run.sound)
    for (std::string& warning :
         sound_warnings(world, 1.0 / (world.step_size() * file.outputs.sound_steps)))
      warnings.push_back(std::move(warning));
  print_warnings(warnings);
  std::vector<std::string> written = run.guests.files();
  for (const BodyLog& log : run.logs)
    written.insert(written.end(), log.report().files.begin(), log.report().files.end());
  return {
      world_json(file, world, run.logs, run.guests.json(), ending, run.momentum.error(), warnings),
      ending, std::move(written)};
}

Result<SceneRun> run_world(MixedFile mixed, unsigned threads) {
  SceneFile& file = mixed.file;
  Result<SceneWorld> world = make_world(file, mixed.has_guests());
  if (!world) return error_of_file(file.path, value_error(world.error()));
  const auto of_body = [&](std::size_t i, const Error& error) {
    return Error{error.kind, file.path + ": body '" + world->name(i) + "': " + error.message};
  };
  if (Status s = check_columns(*world); !s) return error_of_file(file.path, s.error());
  mixed.set_guest_step(file.scene.step);
  WorldGuests made;
  if (mixed.has_guests())
    if (Status s = take(made, add_guests(mixed.tets, mixed.cloths, file.path, *world)); !s)
      return s.error();
  if (Status s = begin_run(file, threads, *world); !s) return s.error();
  WorldRun run;
  if (Status s = take(run.guests, GuestRuns::create(mixed, made, world->steps())); !s)
    return s.error();
  SharedLooks shared;
  for (std::size_t i = 0; i < world->size(); ++i) {
    Result<BodyLog> log = BodyLog::create(file, *world, i, shared);
    if (!log) return of_body(i, log.error());
    run.logs.push_back(std::move(*log));
  }
  if (!file.outputs.wav.empty())
    if (Status s = take(run.sound,
                        WorldSound::create(file.outputs.listen, *world, file.outputs.sound_steps));
        !s)
      return error_of_file(file.path, s.error());
  take_notes(file, *world, run);
  Result<WorldEnding> ending = follow_scene(file, threads, *world, run);
  if (!ending) return ending.error();
  for (BodyLog& log : run.logs)
    if (Status s = log.finish(*world); !s) return s.error();
  if (Status s = run.guests.finish(); !s) return s.error();
  run.end(*ending);
  if (Status s = save_end(file, *world, *ending); !s) return s.error();
  if (run.sound && (ending->exit_code == 0 || ending->signal != 0))
    if (Status s = run.sound->write(file.outputs.wav); !s) return s.error();
  return report_of(file, *world, run, *ending);
}

}  // namespace

std::vector<NamedFile> inputs_of(const Scene& scene) {
  std::vector<NamedFile> inputs;
  std::set<std::string> seen;
  const auto add = [&](const std::string& path, const char* role) {
    if (!path.empty() && seen.insert(path).second) inputs.push_back({path, role});
  };
  const auto add_ids = [&](const std::string& selector, const char* whose) {
    if (selector.find("file:") != std::string::npos) add_ids_of(selector, whose, inputs);
  };
  for (const SceneBody& body : scene.bodies) {
    add(body.model, "a basis file");
    if (body.rigid) add(body.rigid->mesh, "a body's mesh");
    add(body.shape_file, "a body's shape");
    for (const SceneLoad& load : body.loads) add_ids(load.at, "a load");
    for (const std::string& probe : body.columns.probes) add_ids(probe, "a probe");
  }
  for (const SceneCollider& collider : scene.colliders) add(collider.file, "a collider file");
  for (const SceneHand& hand : scene.hands) add_ids(hand.at, "a hand");
  for (const SceneJoint& joint : scene.joints) {
    add_ids(joint.at, "a joint");
    add_ids(joint.to_at, "a joint");
  }
  return inputs;
}

std::vector<NamedFile> inputs_of(const MixedFile& mixed) {
  std::vector<NamedFile> inputs = inputs_of(mixed.file);
  for (const TetSceneBody& body : mixed.tets)
    inputs.push_back({body.model, "a file of tetrahedra"});
  for (const ClothSceneBody& body : mixed.cloths)
    if (!body.cloth().file.empty()) inputs.push_back({body.cloth().file, "a cloth's mesh", true});
  return inputs;
}

std::vector<NamedFile> inputs_of(const SceneFile& file) {
  std::vector<NamedFile> inputs = inputs_of(file.scene);
  inputs.push_back({file.path, "the scene"});
  inputs.push_back({file.outputs.restore, "--restore"});
  for (const std::string& csv : file.files) inputs.push_back({csv, "a CSV file of the scene"});
  // BODY:SELECTOR or a selector alone, which may have a colon, too.
  const std::string& listen = file.outputs.listen;
  add_ids_of(listen, "--listen", inputs);
  add_ids_of(listen.substr(listen.find(':') + 1), "--listen", inputs);
  return inputs;
}

int run_world_command(const MixedFile& mixed, unsigned threads, bool json) {
  return run_scene(inputs_of(mixed), outputs_of(mixed), mixed.file.outputs, json,
                   [&] { return run_world(mixed, threads); });
}

}  // namespace tremolo
