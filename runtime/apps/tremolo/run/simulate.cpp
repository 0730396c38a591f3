#include "runtime/apps/tremolo/run/simulate.h"

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "common/units.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/run/recorder.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/run/run_files.h"
#include "runtime/apps/tremolo/run/run_progress.h"
#include "runtime/apps/tremolo/run/sound.h"
#include "runtime/apps/tremolo/run/watch.h"
#include "runtime/apps/tremolo/start/run_notes.h"
#include "runtime/io/scenes/csv_rows.h"
#include "runtime/scene/selection.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

// Steps between two measurements: the memory that one uses costs the next step some microseconds,
// and a signal waits for up to a block.
constexpr std::size_t kBlock = 64;
constexpr std::chrono::seconds kFlushEvery{1};  // the CSV can be followed so closely

RunReport start_report(const RunOptions& options, const Body& body) {
  RunReport report;
  report.name = options.name;
  report.integrator = options.integrator;
  report.step = options.step;
  report.duration = options.duration;
  report.first_frequency = hertz(body.model().lambda()(0));
  report.scale = options.scale;
  report.split = body.integrator().split();
  return report;
}

// Connections of a run to the outside: the signal that ends it early and the display of its
// progress; null: none.
struct RunLinks {
  const Interruption* interruption = nullptr;
  ToldProgress* progress = nullptr;
};

// Steps the body to the end of its time and passes every state to `watch`. False: the run ended
// early, with the reason in the report.
Result<bool> follow(Body& body, std::int64_t steps, const RunLinks& links, Watch& watch,
                    RunReport& report) {
  Moment start;
  look_at(body, start);
  Result<bool> inside = watch.observe(start);
  if (!inside || !*inside) return inside;
  March march(body, kBlock);
  auto flushed = std::chrono::steady_clock::now();
  while (body.steps() < steps && !march.failed()) {
    for (const Moment& moment : march.advance(steps)) {
      inside = watch.observe(moment);
      if (!inside || !*inside) break;
    }
    report.microseconds_per_step = march.microseconds_per_step();
    if (!inside || !*inside) return inside;
    if (links.progress != nullptr) links.progress->reached(body.time());
    if (const auto now = std::chrono::steady_clock::now(); now - flushed > kFlushEvery) {
      flushed = now;
      if (Status status = watch.flush(); !status) return status.error();
    }
    report.signal = links.interruption == nullptr ? 0 : links.interruption->signal();
    if (report.signal != 0) {
      report.exit_code = 128 + report.signal;
      report.reason = fmt::format("ended at t = {:.6g} s by signal {} ({})", body.time(),
                                  report.signal, ::strsignal(report.signal));
      return false;
    }
  }
  if (!march.failed()) return true;
  report.exit_code = exit_code(error_kind(march.failed()->failure));
  report.reason = why_not_made(*march.failed(), body.time());
  return false;
}

Result<RunReport> run_body(const RunOptions& options, const RunInput& input,
                           const RunLinks& links) {
  const Model::Pointer& model = input.model;
  Result<Body> body = make_body(options, model, input.table);
  if (!body) return body.error();
  RecordedColumns columns;
  columns.velocities = options.velocities;
  if (Status s = take(columns.coordinates, coordinates_of(options.coordinates, model->modes())); !s)
    return s.error();
  if (Status s = take(columns.probes, probes_of(options.probes, *model)); !s) return s.error();
  const std::string csv =
      options.out.empty() ? std::string() : (fs::path(options.out) / kTableName).string();
  if (!options.out.empty()) {
    std::error_code error;
    fs::create_directories(options.out, error);
    if (error) return system_error(options.out + ": cannot create: " + error.message());
  }
  Result<Recorder> recorder = Recorder::create(*model, columns, csv);
  if (!recorder) return value_error(recorder.error());

  RunReport report = start_report(options, *body);
  if (links.interruption != nullptr) {  // not a trial
    Eigen::VectorXd load;
    if (Status s = take(load, largest_load(options, *model, input.table)); !s) return s.error();
    report.notes = notes_before(*body, load);
    for (const std::string& note : report.notes) tell("{}: note: {}\n", options.name, note);
  }
  const std::int64_t steps = std::llround(options.duration / options.step);
  Result<Watch> watch =
      Watch::create(options, *body, columns.probes.empty() ? nullptr : columns.probes.data(), steps,
                    std::move(*recorder), report);
  if (!watch) return value_error(watch.error());
  const Result<bool> whole = follow(*body, steps, links, *watch, report);
  if (!whole) return whole.error();
  if (Status status = watch->finish(); !status) return status.error();
  return report;
}

// Makes the run once without writing anything and measures its largest displacement.
Result<LoadAttempt> attempt(const RunOptions& options, const RunInput& input, double scale) {
  RunOptions trial = options;
  trial.scale = scale;
  trial.out.clear();
  trial.surfaces = 0;
  trial.plot = false;
  trial.wav.clear();
  trial.probes.clear();
  trial.coordinates.clear();
  ToldProgress progress(fmt::format("{}, load times {:.4g}", options.name, scale),
                        options.duration);
  const Result<RunReport> report = run_body(trial, input, {nullptr, &progress});
  if (!report) return report.error();
  if (!(report->size > 0)) return content_error(options.model + ": the surface has no size");
  return LoadAttempt{scale,
                     report->exit_code != 0 ? std::numeric_limits<double>::infinity()
                                            : report->farthest.distance / report->size,
                     report->reason};
}

Result<double> scale_for_deflection(const RunOptions& options, const RunInput& input) {
  const Result<double> share = parse_share(options.deflect);
  if (!share) return share.error();
  const Result<LoadScale> found =
      search_load_scale(*share, [&](double scale) { return attempt(options, input, scale); });
  if (!found) return found.error();
  if (!(found->scale > 0))
    return content_error("--deflect " + options.deflect +
                         ": no factor of the load gives that: " + found->trouble);
  tell("{}: the load times {:.4g} moves it by {} of its size\n", options.name, found->scale,
       options.deflect);
  return found->scale;
}

// Chooses the steps per sample for a run with --wav and without --step.
Status choose_sound_steps(const Model& model, RunOptions& options) {
  if (options.wav.empty() || options.sound_steps > 0) return Success{};
  const Result<IntegratorOptions> settings = integrator_options(options);
  if (!settings) return settings.error();
  options.sound_steps = steps_a_sample(model, options.integrator, *settings, 1.0 / options.step);
  options.step /= options.sound_steps;
  return Success{};
}

void tell_nearest(const RunOptions& options, const Model& model) {
  for (const std::string& note : nearest_of(options.at, model)) tell("  --at {}\n", note);
  for (const std::string& probe : options.probes)
    for (const std::string& note : nearest_of(probe, model)) tell("  --probe {}\n", note);
}

}  // namespace

Result<RunInput> prepare_run(const RunOptions& options) {
  if (Status status = check_run(options); !status) return status.error();
  const Result<Model::Pointer> model = load_model(options);
  if (!model) return model.error();
  tell_nearest(options, **model);
  RunInput input{*model, {}, options};
  if (Status s = choose_sound_steps(**model, input.options); !s) return s.error();
  if (!options.signal.empty())
    if (Status s = take(input.table, read_signal(options.signal)); !s) return s.error();
  if (!options.deflect.empty())
    if (Status s = take(input.options.scale, scale_for_deflection(options, input)); !s)
      return s.error();
  return input;
}

Result<RunReport> simulate(const RunOptions& options) {
  const Result<RunInput> input = prepare_run(options);
  if (!input) return input.error();
  const Result<std::optional<RigidLoss>> rigid = rigid_loss(options, *input->model);
  if (!rigid) return rigid.error();
  const Interruption interruption;
  ToldProgress progress(options.name, options.duration);
  Result<RunReport> report = run_body(input->options, *input, {&interruption, &progress});
  if (!report) return report;
  report->rigid = *rigid;
  if (options.wav.empty()) return report;
  const RunOptions& used = input->options;
  const Result<IntegratorOptions> settings = integrator_options(used);
  if (settings)
    report->sound_warning = sound_warning(*input->model, used.integrator, *settings,
                                          1.0 / (used.step * used.sound_steps));
  return report;
}

}  // namespace tremolo
