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
#include "common/units.h"
#include "formats/file/atomic_file.h"
#include "runtime/apps/tremolo/output/plot.h"
#include "runtime/apps/tremolo/output/scene_places.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/output/text_values.h"
#include "runtime/apps/tremolo/output/warnings.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/run/run_files.h"
#include "runtime/apps/tremolo/run/run_progress.h"
#include "runtime/apps/tremolo/start/run_notes.h"
#include "runtime/apps/tremolo/world/body_log.h"
#include "runtime/apps/tremolo/world/scene_ending.h"
#include "runtime/apps/tremolo/world/world_commands.h"
#include "runtime/apps/tremolo/world/world_sound.h"
#include "runtime/apps/tremolo/world/world_tets_run.h"
#include "runtime/contact/solve/contact_step.h"
#include "runtime/contact/solve/shape_reach.h"

namespace tremolo {
namespace {

constexpr std::size_t kShown = 12;  // bodies whose lines a run prints

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// The end of a run of a world.
struct WorldEnding : SceneEnding {
  double seconds = 0.0;    // of the steps: processor time, with several threads by the clock
  std::int64_t steps = 0;  // that this run made
};

double wall_time() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

Json json_quaternion(const Eigen::Quaterniond& q) {
  return {number_or_null(q.w()), number_or_null(q.x()), number_or_null(q.y()),
          number_or_null(q.z())};
}

Json json_causes(const EnergyAccount& account) {
  return {{"load", number_or_null(account.load)},
          {"support", number_or_null(account.support)},
          {"gravity", number_or_null(account.gravity)},
          {"contact", number_or_null(account.contact_given)},
          {"friction", number_or_null(account.friction)},
          {"restitution", number_or_null(account.restitution)},
          {"damping", number_or_null(account.damping)},
          {"hand", number_or_null(account.hand)},
          {"joint", number_or_null(account.joint)}};
}

Json body_json(const SceneBody& body, const BodyReport& report, double step) {
  Json json;
  json["body"] = body.name;
  json["model"] = solid_name(body);
  json["integrator"] = body.integrator;
  json["kind"] = kind_name(body);
  json["steps"] = report.steps;
  json["reached"] = static_cast<double>(report.steps) * step;
  json["iterations_per_step"] =
      number_or_null(static_cast<double>(report.iterations) / static_cast<double>(report.steps));
  json["halved_steps"] = report.halved_steps;
  const std::pair<const char*, const BodyPlace&> places[] = {{"_initial", report.start},
                                                             {"_final", report.end}};
  for (const auto& [when, place] : places) {
    const std::string ending = when;
    json["position" + ending] = vector_json(place.pose.position);
    json["quaternion" + ending] = json_quaternion(place.pose.rotation);
    json["linear_momentum" + ending] = vector_json(place.momenta.linear);
    json["angular_momentum" + ending] = vector_json(place.momenta.angular);
  }
  const EnergyAccount& account = report.account;
  json["energy_initial"] = number_or_null(account.at_start);
  json["energy_final"] = number_or_null(account.total());
  json["energy_max"] = number_or_null(report.energy_max);
  json["energy_by_cause"] = json_causes(account);
  json["energy_balance_error"] = number_or_null(report.balance_error());
  json["high_band_final"] = number_or_null(report.high_band_final);
  json["work"] = number_or_null(account.given() - account.damping);
  json["dissipated"] = number_or_null(-account.damping);
  json["size"] = number_or_null(report.size);
  json["largest_displacement"] = number_or_null(report.largest_displacement);
  json["largest_displacement_share"] = number_or_null(report.largest_displacement / report.size);
  json["contacts"] = report.contacts;
  json["contact_energy"] = number_or_null(account.contact);
  json["contact_error"] = number_or_null(account.contact_error);
  json["penetration_max"] = number_or_null(report.penetration_max);
  json["penetration_surface_max"] = number_or_null(report.penetration_surface_max);
  json["rebound"] = report.rebound ? number_or_null(*report.rebound) : Json(nullptr);
  json["contact_begins_within"] = number_or_null(report.begins_within);
  json["friction_held_steps"] = report.friction_held_steps;
  Json impulses = Json::object();
  for (const auto& [collider, impulse] : report.collider_impulses)
    impulses[collider] = {number_or_null(impulse.x()), number_or_null(impulse.y()),
                          number_or_null(impulse.z())};
  json["collider_impulses"] = impulses;
  json["contact_speed_max"] = number_or_null(report.contact_speed_max);
  json["passed_through"] = report.passed_through;
  json["asleep"] = report.asleep;
  json["exit_code"] = report.exit_code;
  json["reason"] = report.reason.empty() ? Json(nullptr) : Json(report.reason);
  json["notes"] = report.notes;
  json["files"] = report.files;
  return json;
}

// joint: null where its time is over.
Json joint_json(const SceneJoint& wanted, const Joint* joint) {
  const Joint now = joint == nullptr ? Joint{} : *joint;
  return {{"body", wanted.body},
          {"to", wanted.to},
          {"holds", joint != nullptr},
          {"stiffness", joint == nullptr ? Json(nullptr) : Json(now.stiffness)},
          {"damping", joint == nullptr ? Json(nullptr) : Json(now.damping)},
          {"force", vector_json(now.force)},
          {"energy", number_or_null(now.energy)},
          {"damped", number_or_null(now.damped)}};
}

Json hand_json(const SceneHand& wanted, const MovingHand& hand, const Eigen::Vector3d& force) {
  Json json{{"body", wanted.body}, {"at", wanted.at}, {"holds", hand.holds()}};
  const auto& spring = hand.spring();
  json["stiffness"] = spring ? number_or_null(spring->stiffness) : Json(nullptr);
  json["damping"] = spring ? number_or_null(spring->damping) : Json(nullptr);
  json["force"] = vector_json(force);
  return json;
}

// Springs that mass and step do not allow.
void add_spring_warnings(const Scene& scene, const SceneWorld& world, Warnings& warnings) {
  const auto warn = [&warnings](const std::string& whose, double asked, double used) {
    if (used < asked)
      warnings.push_back(fmt::format(
          "{}: its stiffness of {:.4g} N/m is more than mass and step allow, {:.4g} N/m is used: "
          "a shorter step allows more, as one over its square",
          whose, asked, used));
  };
  for (std::size_t i = 0; i < scene.hands.size(); ++i) {
    const SceneHand& wanted = scene.hands[i];
    if (const auto& spring = world.hand(i).spring(); spring && !wanted.pin)
      warn(fmt::format("hand {} (body '{}', at {})", i + 1, wanted.body, wanted.at),
           wanted.stiffness, spring->stiffness);
  }
  for (std::size_t i = 0; i < scene.joints.size(); ++i) {
    const SceneJoint& wanted = scene.joints[i];
    if (world.joint(i) != nullptr && wanted.options.stiffness)
      warn(fmt::format("joint {} (body '{}', to '{}')", i + 1, wanted.body, wanted.to),
           *wanted.options.stiffness, world.joint(i)->stiffness);
  }
}

// Adds a warning per model about bodies whose first mode the step does not resolve.
void add_step_warnings(const Scene& scene, const SceneWorld& world, Warnings& warnings) {
  std::vector<const Model*> seen;
  for (std::size_t i = 0; i < world.size(); ++i) {
    const Model& model = world.body(i).model();
    if (std::find(seen.begin(), seen.end(), &model) != seen.end()) continue;
    seen.push_back(&model);
    if (model.modes() == 0) continue;
    const std::string warning =
        step_warning(hertz(model.lambda()(0)), world.step_size(),
                     "body '" + scene.bodies[i].name + "': its ", "a step of ");
    if (!warning.empty()) warnings.push_back(warning);
  }
}

// Shapes that extend beyond their bodies, one warning a model.
void add_shape_warnings(const Scene& scene, const SceneWorld& world, Warnings& warnings) {
  std::vector<const Model*> seen;
  for (std::size_t i = 0; i < world.size(); ++i) {
    const Model& model = world.body(i).model();
    const ContactStep* contact = world.body(i).contact();
    if (contact == nullptr || contact->shape() == nullptr) continue;
    if (std::find(seen.begin(), seen.end(), &model) != seen.end()) continue;
    seen.push_back(&model);
    const ShapeReach reach = shape_beyond(model, *contact->shape());
    if (reach.distance <= kShapeBeyond * reach.size) continue;
    warnings.push_back(fmt::format(
        "body '{}': its shape: {}: other bodies bump into what its own points do not feel; use a "
        "smaller shape",
        scene.bodies[i].name, reach_text(*contact->shape(), reach)));
  }
}

Json world_json(const SceneFile& file, const SceneWorld& world, const std::vector<BodyLog>& logs,
                const WorldTetsRun& tets, const WorldEnding& ending, const Warnings& warnings) {
  Json json;
  json["schema"] = kReportSchema;
  json["scene"] = file.path;
  json["step"] = world.step_size();
  json["duration"] = file.scene.duration;
  json["steps"] = world.steps();
  json["reached"] = world.time();
  const double each = 1e6 * ending.seconds / static_cast<double>(ending.steps);
  json["microseconds_per_step"] = number_or_null(each);
  json["real_time_factor"] = number_or_null(world.step_size() * 1e6 / each);
  double worst = 0.0;
  for (const BodyLog& log : logs) worst = std::max(worst, log.report().balance_error());
  json["energy_balance_error"] = number_or_null(worst);
  json["contact_speed_limit"] = number_or_null(world.contact_speed_limit());
  json["exit_code"] = ending.exit_code;
  json["reason"] = ending.reason.empty() ? Json(nullptr) : Json(ending.reason);
  json["bodies"] = Json::array();
  for (std::size_t i = 0; i < logs.size(); ++i)
    json["bodies"].push_back(body_json(file.scene.bodies[i], logs[i].report(), world.step_size()));
  for (std::size_t i = 0; i < tets.size(); ++i) json["bodies"].push_back(tets.body_json(i));
  json["joints"] = Json::array();
  for (std::size_t i = 0; i < file.scene.joints.size(); ++i)
    json["joints"].push_back(joint_json(file.scene.joints[i], world.joint(i)));
  json["hands"] = Json::array();
  for (std::size_t i = 0; i < file.scene.hands.size(); ++i)
    json["hands"].push_back(hand_json(file.scene.hands[i], world.hand(i), world.hand_force(i)));
  json["warnings"] = warnings;
  return json;
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
  for (const TetSceneBody& body : mixed.tets) names.push_back(body.name);
  outputs.add_folder(out, names);
  outputs.add_files(out, {kReportName});
  for (const SceneBody& body : file.scene.bodies)
    if (!out.empty()) outputs.add_files((fs::path(out) / body.name).string(), body_files());
  add_tets_outputs(mixed, outputs);
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
    ending.reason = "body '" + log.name() + "': " + log.report().reason;
  }
}

// Steps the world to the end of its time. clock: s, of the steps. sound: null without --wav. An
// orbit or a step that fails ends the run.
Result<WorldEnding> follow_world(const SceneFile& file, SceneWorld& world,
                                 std::vector<BodyLog>& logs, WorldTetsRun& tets, WorldSound* sound,
                                 double (*clock)()) {
  const Interruption interruption;
  ToldProgress progress(fs::path(file.path).stem().string(), file.scene.duration);
  const std::int64_t steps = std::llround(file.scene.duration / file.scene.step);
  const std::int64_t before_it = world.steps();
  WorldEnding ending;
  Result<bool> inside = observe_all(world, logs);
  if (Status s = tets.observe(); !s) return s.error();
  if (sound != nullptr) sound->add(world);
  while (inside && *inside && world.steps() < steps && ending.exit_code == 0) {
    const double before = clock();
    const auto failures = world.step();
    ending.seconds += clock() - before;
    for (const auto& [body, report] : failures) logs[body].give_up(report, world.body(body).time());
    inside = observe_all(world, logs);
    if (Status s = tets.observe(); !s) return s.error();
    if (sound != nullptr) sound->add(world);
    tell_end(logs, ending);
    tets.ended(ending);
    progress.reached(world.time());
    ending.interrupted(interruption.signal(), world.time());
  }
  if (!inside) return inside.error();
  ending.steps = world.steps() - before_it;
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

void print_bodies(const SceneFile& file, const SceneWorld& world,
                  const std::vector<BodyLog>& logs) {
  const std::size_t shown = std::min(logs.size(), kShown);
  for (std::size_t i = 0; i < shown; ++i) {
    const BodyReport& report = logs[i].report();
    const EnergyAccount& account = report.account;
    tell("  {} ({}, {}): energy {:.6g} -> {:.6g} J; ", file.scene.bodies[i].name,
         kind_name(file.scene.bodies[i]), file.scene.bodies[i].integrator, account.at_start,
         account.total());
    tell("load {:.4g}, support {:.4g}, gravity {:.4g}, damping {:.4g} J; balance to {:.1e}\n",
         account.load, account.support, account.gravity, account.damping, report.balance_error());
    if (world.body(i).contact() != nullptr)
      tell(
          "    contact {:.4g}, restitution {:.4g}, friction {:.4g}, hand {:.4g}, joint {:.4g} J; "
          "{} "
          "contacts, its points {:.3g} % of its size deep at most, its surface {:.3g} %{}\n",
          account.contact_given, account.restitution, account.friction, account.hand, account.joint,
          report.contacts, 100 * report.penetration_max,
          100 * report.penetration_surface_max / report.size,
          report.rebound ? fmt::format(", rebound {:.3g}", *report.rebound) : std::string());
    if (report.size > 0)
      tell("    deformed by {:.4g} m at most, {:.3g} % of its size\n", report.largest_displacement,
           100 * report.largest_displacement / report.size);
    if (!report.files.empty())
      tell("    wrote into {}: {}\n", logs[i].folder(), list_files(report.files));
  }
  std::int64_t passed = 0;
  for (const BodyLog& log : logs) passed += log.report().passed_through;
  if (passed > 0)
    tell(
        "  {} times a contact point went through what it met within a step: say a shorter --step\n",
        passed);
  if (shown < logs.size()) tell("  and {} more bodies; --json lists all\n", logs.size() - shown);
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

// written: paths.
struct WorldRun {
  Json json;
  WorldEnding ending;
  std::vector<std::string> written;
};

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

Result<WorldRun> run_world(MixedFile mixed, unsigned threads) {
  SceneFile& file = mixed.file;
  Result<SceneWorld> world = make_world(file, !mixed.tets.empty());
  if (!world) return error_of_file(file.path, value_error(world.error()));
  if (Status s = world->set_threads(threads); !s) return s.error();
  if (Status s = begin_where_saved(file, *world); !s) return s.error();
  const auto of_body = [&](std::size_t i, const Error& error) {
    return Error{error.kind, file.path + ": body '" + world->name(i) + "': " + error.message};
  };
  for (std::size_t i = 0; i < world->size(); ++i)
    if (Status s = check_columns(*world, i); !s) return of_body(i, s.error());
  for (TetSceneBody& body : mixed.tets) body.options.step = file.scene.step;
  Result<WorldTetsRun> tets = WorldTetsRun::create(mixed, *world);
  if (!tets) return tets.error();
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
      follow_world(file, *world, logs, *tets, sound ? &*sound : nullptr, clock);
  if (!ending) return ending.error();
  for (BodyLog& log : logs)
    if (Status s = log.finish(*world); !s) return s.error();
  if (Status s = tets->finish(); !s) return s.error();
  tell_end(logs, *ending);
  if (Status s = save_end(file, *world, *ending); !s) return s.error();
  if (sound && (ending->exit_code == 0 || ending->signal != 0))
    if (Status s = sound->write(file.outputs.wav); !s) return s.error();
  tell("{}: {} bodies reached {:.6g} of {:.6g} s in steps of {:.4g} s, {:.2f} us each\n",
       fs::path(file.path).stem().string(), world->size() + tets->size(), world->time(),
       file.scene.duration, world->step_size(),
       1e6 * ending->seconds / static_cast<double>(ending->steps));
  print_bodies(file, *world, logs);
  tets->print();
  Warnings warnings = keyframe_warnings(file.scene.bodies, file.scene.colliders);
  add_step_warnings(file.scene, *world, warnings);
  add_shape_warnings(file.scene, *world, warnings);
  add_spring_warnings(file.scene, *world, warnings);
  if (sound)
    for (std::string& warning :
         sound_warnings(*world, 1.0 / (world->step_size() * file.outputs.sound_steps)))
      warnings.push_back(std::move(warning));
  print_warnings(warnings);
  std::vector<std::string> written = tets->files();
  for (const BodyLog& log : logs)
    written.insert(written.end(), log.report().files.begin(), log.report().files.end());
  return WorldRun{world_json(file, *world, logs, *tets, *ending, warnings), *ending,
                  std::move(written)};
}

}  // namespace

const char* kind_name(const SceneBody& body) {
  if (body.rigid) return "rigid";
  if (body.kind == FrameKind::kFree) return "free";
  return body.kind == FrameKind::kDriven ? "driven" : "fixed";
}

std::string solid_name(const SceneBody& body) {
  if (!body.rigid) return body.model;
  return body.rigid->shape ? shape_name(*body.rigid->shape) : body.rigid->mesh;
}

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
  const SceneFile& file = mixed.file;
  const std::vector<NamedFile> inputs = inputs_of(mixed);
  const RunOutputs outputs = outputs_of(mixed);
  if (Status s = outputs.check(inputs); !s) return report_error(s.error());
  const GuardedInputs guard(inputs);
  const Result<WorldRun> run = run_world(mixed, threads);
  if (!run) return report_error(run.error());
  return end_scene_run(file.outputs, outputs, run->written, run->json, run->ending, json);
}

}  // namespace tremolo
