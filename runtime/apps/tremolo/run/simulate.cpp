#include "runtime/apps/tremolo/run/simulate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "common/units.h"
#include "runtime/apps/tremolo/output/run_progress.h"
#include "runtime/apps/tremolo/output/sound.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/run/body_files.h"
#include "runtime/apps/tremolo/run/follow.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/run/watch.h"
#include "runtime/apps/tremolo/start/run_notes.h"
#include "runtime/scene/selection.h"

namespace tremolo {
namespace {

// A signal waits for up to a block.
constexpr std::int64_t kBlock = 64;

RunReport start_report(const BodyScene& scene, const SceneWorld& world) {
  const Body& body = world.body(0);
  RunReport report;
  report.name = scene.body().name;
  report.model = scene.body().model;
  report.integrator = scene.body().integrator;
  report.step = scene.step();
  report.duration = scene.file.scene.duration;
  report.first_frequency = hertz(body.model().lambda()(0));
  report.scale = scene.load().scale;
  report.split = body.integrator().split();
  report.energy_initial = world.account(0).at_start;
  return report;
}

// interruption: null for a trial.
Result<RunReport> run_body(const RunInput& input, unsigned threads,
                           const Interruption* interruption, ToldProgress& progress) {
  const BodyScene& scene = input.scene;
  Result<SceneWorld> world = world_of_one(input);
  if (!world) return world.error();
  if (Status s = begin_run(scene.file, threads, *world); !s) return s.error();
  const ContactBody& body = world->body(0);
  const Result<RecordedColumns> columns = recorded_columns(scene.body().columns, *input.model);
  if (!columns) return columns.error();
  const std::int64_t steps = std::llround(scene.file.scene.duration / scene.step());
  Result<BodyFiles> files =
      BodyFiles::create(scene.file.outputs, *columns, *input.model, {world->steps(), steps});
  if (!files) return files.error();

  RunReport report = start_report(scene, *world);
  if (interruption != nullptr) {
    Eigen::VectorXd load;
    if (Status s = take(load, largest_load(input)); !s) return s.error();
    report.notes = notes_before(body, load);
    for (const std::string& note : report.notes) tell("{}: note: {}\n", report.name, note);
  }
  Result<Watch> watch = Watch::create(scene, *world, kBlock,
                                      columns->probes.empty() ? nullptr : columns->probes.data(),
                                      steps, std::move(*files), report);
  if (!watch) return value_error(watch.error());
  const Result<WorldEnding> ending =
      follow(*world, {scene.file.scene.duration, kBlock, threads, &progress, interruption}, *watch);
  if (!ending) return ending.error();
  static_cast<RunEnding&>(report) = *ending;
  report.microseconds_per_step =
      1e6 * ending->seconds / static_cast<double>(std::max<std::int64_t>(ending->steps, 1));
  if (Status status = watch->finish(); !status) return status.error();
  if (Status s = save_end(scene.file, *world, *ending); !s) return s.error();
  return report;
}

// Makes the run once without writing anything and measures its largest displacement.
Result<LoadAttempt> attempt(const RunInput& input, double scale) {
  RunInput trial = input;
  trial.scene.load().scale = scale;
  trial.scene.file.outputs = {};
  trial.scene.body().columns = {};
  const SceneBody& body = trial.scene.body();
  ToldProgress progress(fmt::format("{}, load times {:.4g}", body.name, scale),
                        trial.scene.file.scene.duration);
  const Result<RunReport> report = run_body(trial, 1, nullptr, progress);
  if (!report) return report.error();
  if (!(report->size > 0)) return content_error(body.model + ": the surface has no size");
  return LoadAttempt{scale,
                     report->exit_code != 0 ? std::numeric_limits<double>::infinity()
                                            : report->farthest.distance / report->size,
                     report->reason};
}

Result<double> scale_for_deflection(const RunInput& input) {
  const std::string& deflect = input.scene.deflect;
  const Result<double> share = parse_share(deflect);
  if (!share) return share.error();
  const Result<LoadScale> found =
      search_load_scale(*share, [&](double scale) { return attempt(input, scale); });
  if (!found) return found.error();
  if (!(found->scale > 0))
    return content_error("--deflect " + deflect +
                         ": no factor of the load gives that: " + found->trouble);
  tell("{}: the load times {:.4g} moves it by {} of its size\n", input.scene.body().name,
       found->scale, deflect);
  return found->scale;
}

// Chooses the steps per sample for a run with --wav and without --step.
void choose_sound_steps(const Model& model, BodyScene& scene) {
  SceneOutputs& outputs = scene.file.outputs;
  if (outputs.wav.empty() || outputs.sound_steps > 0) return;
  outputs.sound_steps =
      steps_a_sample(model, scene.body().integrator, scene.settings(), 1.0 / scene.step());
  scene.file.scene.step /= outputs.sound_steps;
}

void tell_nearest(const BodyScene& scene, const Model& model) {
  for (const std::string& note : nearest_of(scene.load().at, model)) tell("  --at {}\n", note);
  for (const std::string& probe : scene.body().columns.probes)
    for (const std::string& note : nearest_of(probe, model)) tell("  --probe {}\n", note);
}

}  // namespace

Result<RunInput> prepare_run(const BodyScene& scene) {
  Result<RunInput> input = load_body(scene);
  if (!input) return input;
  tell_nearest(scene, *input->model);
  choose_sound_steps(*input->model, input->scene);
  if (!scene.deflect.empty())
    if (Status s = take(input->scene.load().scale, scale_for_deflection(*input)); !s)
      return s.error();
  return input;
}

Result<RunReport> simulate(const BodyScene& scene, unsigned threads) {
  const Result<RunInput> input = prepare_run(scene);
  if (!input) return input.error();
  const Result<std::optional<RigidLoss>> rigid = rigid_loss(*input);
  if (!rigid) return rigid.error();
  const Interruption interruption;
  ToldProgress progress(scene.body().name, scene.file.scene.duration);
  Result<RunReport> report = run_body(*input, threads, &interruption, progress);
  if (!report) return report;
  report->rigid = *rigid;
  const BodyScene& used = input->scene;
  if (!used.file.outputs.wav.empty())
    report->sound_warning = sound_warning(*input->model, used.body().integrator, used.settings(),
                                          1.0 / (used.step() * used.file.outputs.sound_steps));
  return report;
}

}  // namespace tremolo
