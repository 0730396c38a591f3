#include "runtime/program/reproduce/reproduce.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <thread>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "runtime/program/commands.h"
#include "runtime/program/known/known_answers.h"
#include "runtime/program/report/page.h"
#include "runtime/program/reproduce/experiment3.h"
#include "runtime/program/reproduce/figures.h"
#include "runtime/program/reproduce/file_bytes.h"
#include "runtime/program/reproduce/loads.h"
#include "runtime/program/reproduce/runs.h"
#include "runtime/program/reproduce/tables.h"
#include "runtime/program/reproduce/thesis.h"

namespace tremolo {
namespace reproduce {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  std::vector<Criterion> criteria;
  std::vector<Survivors> survivors;  // table 3
};

void note(const std::string& text) {
  fmt::print(stderr, "tremolo: {}\n", text);
}

Result<Workshop> open_workshop(const ReproduceOptions& options) {
  Result<std::vector<SampleModel>> models =
      load_sample_models(options.models_directory, options.models);
  if (!models) return models.error();
  const std::string directory = (fs::path(options.out) / "store").string();
  Result<Store> store = Store::open(directory);
  if (!store) return store.error();
  Result<std::string> program = file_bytes("/proc/self/exe");
  if (!program) return program.error();
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  return Workshop{
      std::move(*store),  directory,
      checksum(*program), options.threads < 1 ? cores : static_cast<unsigned>(options.threads),
      std::move(*models), options.long_form};
}

std::vector<RunName> all_runs(const Workshop& shop) {
  std::vector<RunName> runs;
  const auto add = [&](const std::string& method, double another) {
    const std::vector<RunName> some = the_runs(shop.models, method, another);
    runs.insert(runs.end(), some.begin(), some.end());
  };
  for (const std::string& method : methods()) add(method, 1.0);
  for (const double another : {3.0, 10.0}) {
    if (has_method("ep4")) add("ep4", another);
    add("imexv", another);
  }
  return runs;
}

// A table on the page and as NAME.csv.
Status add_table(Page& page, const Table& table, const std::string& caption,
                 const std::string& directory, const std::string& name) {
  page.table(table, caption);
  return write_csv(table, (fs::path(directory) / (name + ".csv")).string());
}

std::string survivors_text(const std::vector<Survivors>& list) {
  std::vector<std::string> parts;
  for (const Survivors& one : list)
    parts.push_back(fmt::format("{} {} of {}", one.method, one.reached, one.of));
  return fmt::format("{}", fmt::join(parts, ", "));
}

Status add_reached(Page& page, const Workshop& shop, const Orbits& orbits,
                   const std::string& directory, Outcome& outcome) {
  page.section("Table 3: how far the 36 runs come");
  page.paragraph(fmt::format(
      "Impulse (3 ms), square (0.3 s) and sine (1 Hz) at the model's default load times a factor, "
      "without damping and with alpha = 0.3, h = 3 ms, 30 s. The thesis gives no forces. For beam "
      "and tower the sine's factor is the one at which `imexv` with its fixed split breaks off "
      "most "
      "nearly when the thesis's does: tower at {:g}; beam at {:g}, where no factor gives both 6.86 "
      "s undamped and 7.12 s damped: those that break off damped after 7 s break off undamped "
      "after 2 to 3 s. All other factors are 1. * marks a run that broke off: the solver gave up, "
      "or the energy exceeded ten times all that was put in.",
      load_factor("tower", SignalKind::kSine), load_factor("beam", SignalKind::kSine)));
  for (const std::string& method : methods())
    outcome.survivors.push_back(count_survivors(shop, orbits, method));
  const Table table = reached_table(shop, orbits);
  const std::string caption = fmt::format(
      "Seconds reached of 30. Runs that reach the end: thesis "
      "33 of 36; ours: {}.",
      survivors_text(outcome.survivors));
  if (Status status = add_table(page, table, caption, directory, "table-3"); !status) return status;
  for (const Survivors& one : outcome.survivors) {
    if (one.method != "ep4" && one.method != "imexv-adaptive") continue;
    outcome.criteria.push_back({fmt::format("{}: runs that reach 30 s", one.method),
                                fmt::format("{} of {}", one.of, one.of),
                                fmt::format("{} of {}", one.reached, one.of),
                                one.reached == one.of});
  }
  page.heading("Loads times 3 and 10");
  page.paragraph("The same runs pushed harder still, with ep4 and, for contrast, imexv.");
  for (const double another : {3.0, 10.0})
    if (has_method("ep4")) {
      const Survivors one = count_survivors(shop, orbits, "ep4", another);
      outcome.criteria.push_back(
          {fmt::format("ep4, loads times {:g}: runs that reach 30 s", another), "shown; or why not",
           fmt::format("{} of {}", one.reached, one.of), one.reached == one.of, false});
    }
  return add_table(page, strong_loads_table(shop, orbits), "* broke off.", directory,
                   "strong-loads");
}

// What must be said about the thesis's table.
std::string table_note(int table) {
  std::string text = fmt::format("Table {}", table);
  if (table == 5)
    return text +
           ". In the thesis this table repeats table 6, caption and all: its numbers are "
           "those of the square load.";
  if (table == 7)
    return text +
           ". In the thesis the Newmark column repeats table 6, and beam and tower have a "
           "speed-up though IMEXv broke off (*).";
  if (table == 10) return text + ". In the thesis beam has a speed-up though IMEXv broke off (*).";
  return text + ".";
}

Status add_timings(Page& page, const Workshop& shop, const Orbits& orbits, const Timings& timings,
                   const std::string& directory, Outcome& outcome) {
  page.section("Tables 5-10: run time");
  page.paragraph(fmt::format(
      "Seconds for the run (30 s, 10 000 steps), linear systems solved a step, and the speed-up "
      "Newmark / IMEXv. The thesis: Core i5-760, MKL. Ours: step() alone, one thread, the smallest "
      "of three, the methods by turns. Both solvers converge to the same relative residual, {:g} "
      "(imexv-thesis: absolute, in units of q). Runs marked * broke off: their seconds are for the "
      "steps they made; our speed-up is always per step.",
      kTolerance));
  for (const double alpha : thesis::kAlphas)
    for (const SignalKind load : thesis::kLoads) {
      const int number = thesis::run("beam", load, alpha)->table;
      page.heading(fmt::format("Table {}: {}, {}", number, thesis::load_name(load),
                               alpha == 0.0 ? "no damping" : "alpha = 0.3"));
      const Table table = timing_table(shop, load, alpha, orbits, timings);
      if (Status status = add_table(page, table, table_note(number), directory,
                                    fmt::format("table-{}", number));
          !status)
        return status;
    }
  page.paragraph(
      "Where our speed-ups are smaller than the thesis's: a step of ours costs evaluations of the "
      "polynomial more than linear systems. One contraction gives Newmark force and tangent "
      "together, so that splitting saves only the high rows' smaller system, while imexv evaluates "
      "the low rows' force besides. Of the thesis's Newmark it is said only that it is Barbic's "
      "code.");
  page.heading("All methods");
  const Table all = all_timings_table(shop, timings, orbits);
  if (Status status = add_table(page, all, "Microseconds and iterations a step; * broke off.",
                                directory, "timings");
      !status)
    return status;
  outcome.criteria.push_back(speedups(shop, orbits, timings));
  return Success{};
}

Status build_page(Page& page, const Workshop& shop, const std::string& directory,
                  Outcome& outcome) {
  page.section("Table 1: low and high modes at 3 ms");
  page.paragraph(
      "Ours: explicit iff h omega < 1.8 (stability needs 2). The thesis's printed rule f < 1/h is "
      "no stability limit; its counts are not what that rule would give on our models, see the "
      "last "
      "column.");
  if (Status status = add_table(page, modes_table(shop.models), "", directory, "table-1"); !status)
    return status;

  note("the 36 runs of every method, and loads times 3 and 10");
  Result<Orbits> orbits = watch_all(shop, all_runs(shop));
  if (!orbits) return orbits.error();
  if (Status status = add_reached(page, shop, *orbits, directory, outcome); !status) return status;

  note("timings, on one thread");
  Result<Timings> timings = time_all(shop, *orbits);
  if (!timings) return timings.error();
  if (Status status = add_timings(page, shop, *orbits, *timings, directory, outcome); !status)
    return status;

  page.section("Figures 13-16 and 22-35: energy over time");
  page.paragraph(
      "As the thesis arranges them: IMEXv left, Newmark right, below them the same with damping; "
      "ep4 is drawn over both, dashed. The thesis prints pictures only, so there are no values to "
      "put beside ours. A curve that leaves its frame is a run that breaks off.");
  if (Status status = add_energy_figures(page, shop, *orbits, directory); !status) return status;
  page.heading("The same runs in numbers");
  if (Status status = add_table(
          page, energies_table(shop, *orbits),
          "Mean energy after the load has ended, of the whole run if it lasts, and the largest "
          "error of the energy balance (energy_drift_max in docs/architecture.md); * broke off.",
          directory, "energies");
      !status)
    return status;

  note(shop.long_form ? "experiment 3, 10 000 s" : "experiment 3, short form");
  Result<std::vector<Criterion>> third = add_experiment3(page, shop, directory);
  if (!third) return third.error();
  outcome.criteria.insert(outcome.criteria.end(), third->begin(), third->end());

  page.section("Experiment 4: the step");
  if (Status status = add_step_figures(page, shop, directory); !status) return status;

  note("experiments with a known answer");
  // A folder for each build: these experiments do not know the program's checksum.
  const Result<Store> store = Store::open((fs::path(shop.directory) / shop.program).string());
  if (!store) return store.error();
  Result<std::vector<Criterion>> known = add_known_answers(page, *store, directory, shop.long_form);
  if (!known) return known.error();
  outcome.criteria.insert(outcome.criteria.end(), known->begin(), known->end());

  page.section("What was promised, and what was measured");
  page.criteria(outcome.criteria);
  return Success{};
}

nlohmann::ordered_json to_json(const Outcome& outcome, const std::string& report) {
  nlohmann::ordered_json json;
  json["report"] = report;
  json["table_3"]["thesis"] = {{"reached", 33}, {"of", 36}};
  for (const Survivors& one : outcome.survivors)
    json["table_3"][one.method] = {{"reached", one.reached}, {"of", one.of}};
  json["criteria"] = nlohmann::ordered_json::array();
  for (const Criterion& one : outcome.criteria)
    json["criteria"].push_back({{"what", one.what},
                                {"bound", one.bound},
                                {"measured", one.measured},
                                {"met", one.met},
                                {"decides", one.decides}});
  return json;
}

void print_criteria(const Outcome& outcome) {
  for (const Criterion& one : outcome.criteria)
    fmt::print(stderr, "  {:<6} {}: {} ({})\n",
               !one.decides ? "shown"
               : one.met    ? "met"
                            : "MISSED",
               one.what, one.measured, one.bound);
}

}  // namespace
}  // namespace reproduce

int reproduce_command(const ReproduceOptions& options) {
  using namespace reproduce;
  Result<Workshop> shop = open_workshop(options);
  if (!shop) return report_error(shop.error());
  Page page("The thesis reproduced",
            "Huang 2011, Preserving High-Frequency Vibration of Deformable Objects Using the "
            "Implicit-Explicit Variational Integrator: its tables, figures and experiments on "
            "Tremolo's sample models.");
  Outcome outcome;
  if (Status status = build_page(page, *shop, options.out, outcome); !status)
    return report_error(status.error());
  const std::string report = (fs::path(options.out) / "index.html").string();
  if (Status status = page.write(report); !status) return report_error(status.error());
  print_criteria(outcome);
  note("wrote " + report);
  if (options.json)
    std::cout
        << to_json(outcome, report).dump(2, ' ', false, nlohmann::json::error_handler_t::replace)
        << "\n";
  if (!std::cout.flush()) return report_error(system_error("standard output cannot be written"));
  return exit_code(outcome.criteria);
}

}  // namespace tremolo
