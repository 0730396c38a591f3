#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/processor.h"
#include "formats/file/atomic_file.h"
#include "runtime/apps/tremolo/output/plot.h"
#include "runtime/apps/tremolo/output/run_progress.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/run/run_files.h"
#include "runtime/apps/tremolo/start/run_notes.h"
#include "runtime/apps/tremolo/world/body_log.h"
#include "runtime/apps/tremolo/world/guest_report.h"
#include "runtime/apps/tremolo/world/guest_runs.h"
#include "runtime/apps/tremolo/world/world_commands.h"
#include "runtime/apps/tremolo/world/world_momentum.h"
#include "runtime/apps/tremolo/world/world_report.h"
#include "runtime/apps/tremolo/world/world_sound.h"
#include "runtime/world/world_guests.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

double wall_time() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

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
  for (const SceneBody& body : file.scene.bodies)
    if (!out.empty()) outputs.add_files((fs::path(out) / body.name).string(), body_files());
  add_guest_outputs(mixed, outputs);
  return outputs;
}

Result<bool> observe_all(const SceneWorld& world, std::vector<BodyLog>& logs) {
  bool inside = true;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    if (world.failed(i)) continue;
    const Result<bool> one = logs[i].observe(world);
    if (!one) return one.error();
    inside = inside && *one;
  }
  return inside;
}

void tell_end(const std::vector<BodyLog>& logs, WorldEnding& ending) {
  for (const BodyLog& log : logs) {
    if (log.report().exit_code == 0 || ending.exit_code != 0) continue;
    ending.exit_code = log.report().exit_code;
    ending.reason = "body '" + log.report().name + "': " + log.report().reason;
  }
}

// Steps the world to the end of its time. clock: s, of the steps. sound: null without --wav. An
// orbit or a step that fails ends the run.
Result<WorldEnding> follow_world(const SceneFile& file, SceneWorld& world,
                                 std::vector<BodyLog>& logs, GuestRuns& guests, WorldSound* sound,
                                 double (*clock)()) {
  WorldMomentum momentum;
  const Interruption interruption;
  ToldProgress progress(fs::path(file.path).stem().string(), file.scene.duration);
  const std::int64_t steps = std::llround(file.scene.duration / file.scene.step);
  const std::int64_t before_it = world.steps();
  WorldEnding ending;
  Result<bool> inside = observe_all(world, logs);
  if (Status s = guests.observe(); !s) return s.error();
  momentum.observe(world, guests.guests());
  if (sound != nullptr) sound->add(world);
  while (inside && *inside && world.steps() < steps && ending.exit_code == 0) {
    const double before = clock();
    const auto failures = world.step();
    ending.seconds += clock() - before;
    for (const auto& [body, report] : failures) logs[body].give_up(report, world.body(body).time());
    inside = observe_all(world, logs);
    if (Status s = guests.observe(); !s) return s.error();
    momentum.observe(world, guests.guests());
    if (sound != nullptr) sound->add(world);
    tell_end(logs, ending);
    guests.ended(ending);
    progress.reached(world.time());
    ending.interrupted(interruption.signal(), world.time());
  }
  if (!inside) return inside.error();
  ending.steps = world.steps() - before_it;
  ending.momentum_error = momentum.error();
  tell_end(logs, ending);
  return ending;
}

// Prints each note once, for the first body that has it.
void take_notes(const SceneFile& file, const SceneWorld& world, std::vector<BodyLog>& logs) {
  std::vector<std::string> printed;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    const ContactBody& body = world.body(i);
    std::vector<std::string> notes =
        notes_before(body, Eigen::VectorXd::Zero(body.model().modes()));
    if (world.begins_within(i) > 0.0)
      notes.push_back(fmt::format(
          "it begins {:.3g} m within its contact-margin of a collider: its contact begins where it "
          "is, without energy",
          world.begins_within(i)));
    for (const std::string& note : notes) {
      if (std::find(printed.begin(), printed.end(), note) != printed.end()) continue;
      printed.push_back(note);
      tell("{}: note: {}\n", file.scene.bodies[i].name, note);
    }
    logs[i].add_notes(notes);
  }
}

Status begin_where_saved(const SceneFile& file, SceneWorld& world) {
  if (file.outputs.restore.empty()) return Success{};
  if (Status s = world.restore(file.outputs.restore); !s) return s;
  if (world.time() > file.scene.duration * (1.0 + 1e-9))
    return content_error(
        fmt::format("{}: it was saved at t = {:.6g} s, behind the duration of "
                    "{:.6g} s",
                    file.outputs.restore, world.time(), file.scene.duration));
  return Success{};
}

// Also of a run that a signal ends; not of one in which a step or an orbit broke off.
Status save_end(const SceneFile& file, const SceneWorld& world, const WorldEnding& ending) {
  if (file.outputs.save.empty() || (ending.exit_code != 0 && ending.signal == 0)) return Success{};
  if (Status s = world.save(file.outputs.save); !s) return s;
  tell("saved at t = {:.6g} s: {}\n", world.time(), file.outputs.save);
  return Success{};
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

Result<SceneRun> run_world(MixedFile mixed, unsigned threads) {
  SceneFile& file = mixed.file;
  Result<SceneWorld> world = make_world(file, mixed.has_guests());
  if (!world) return error_of_file(file.path, value_error(world.error()));
  if (Status s = world->set_threads(threads); !s) return s.error();
  if (Status s = begin_where_saved(file, *world); !s) return s.error();
  const auto of_body = [&](std::size_t i, const Error& error) {
    return Error{error.kind, file.path + ": body '" + world->name(i) + "': " + error.message};
  };
  for (std::size_t i = 0; i < world->size(); ++i)
    if (Status s = check_columns(*world, i); !s) return of_body(i, s.error());
  mixed.set_guest_step(file.scene.step);
  WorldGuests made;
  if (mixed.has_guests())
    if (Status s = take(made, add_guests(mixed.tets, mixed.cloths, file.path, *world)); !s)
      return s.error();
  Result<GuestRuns> guests = GuestRuns::create(mixed, made);
  if (!guests) return guests.error();
  std::vector<BodyLog> logs;
  SharedLooks shared;
  for (std::size_t i = 0; i < world->size(); ++i) {
    Result<BodyLog> log = BodyLog::create(file, *world, i, shared);
    if (!log) return of_body(i, log.error());
    logs.push_back(std::move(*log));
  }
  take_notes(file, *world, logs);
  std::optional<WorldSound> sound;
  if (!file.outputs.wav.empty())
    if (Status s =
            take(sound, WorldSound::create(file.outputs.listen, *world, file.outputs.sound_steps));
        !s)
      return error_of_file(file.path, s.error());
  const auto clock = threads == 1 ? processor_time : wall_time;
  Result<WorldEnding> ending =
      follow_world(file, *world, logs, *guests, sound ? &*sound : nullptr, clock);
  if (!ending) return ending.error();
  for (BodyLog& log : logs)
    if (Status s = log.finish(*world); !s) return s.error();
  if (Status s = guests->finish(); !s) return s.error();
  tell_end(logs, *ending);
  if (Status s = save_end(file, *world, *ending); !s) return s.error();
  if (sound && (ending->exit_code == 0 || ending->signal != 0))
    if (Status s = sound->write(file.outputs.wav); !s) return s.error();
  tell("{}: {} bodies reached {:.6g} of {:.6g} s in steps of {:.4g} s, {:.2f} us each\n",
       fs::path(file.path).stem().string(), world->size() + guests->size(), world->time(),
       file.scene.duration, world->step_size(),
       1e6 * ending->seconds / static_cast<double>(ending->steps));
  print_bodies(file, *world, logs);
  guests->print();
  Warnings warnings = world_warnings(file.scene, *world);
  if (sound)
    for (std::string& warning :
         sound_warnings(*world, 1.0 / (world->step_size() * file.outputs.sound_steps)))
      warnings.push_back(std::move(warning));
  print_warnings(warnings);
  std::vector<std::string> written = guests->files();
  for (const BodyLog& log : logs)
    written.insert(written.end(), log.report().files.begin(), log.report().files.end());
  return SceneRun{world_json(file, *world, logs, guests->json(), *ending, warnings), *ending,
                  std::move(written)};
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
