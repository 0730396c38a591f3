#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "runtime/apps/tremolo/output/statistics.h"
#include "tests/lab/reproduce/sections.h"

namespace tremolo::reproduce {
namespace {

std::string where_text(const RunName& run) {
  return fmt::format("{}, {}, {}", run.model, thesis::load_name(run.load),
                     run.alpha == 0.0 ? "no damping" : fmt::format("alpha = {:g}", run.alpha));
}

// The runs of the thesis's method and of ours whose end differs from the thesis's.
std::string reached_difference(const Session& session, const Orbits& orbits) {
  std::vector<std::string> parts;
  for (RunName run : thesis_runs(session.models, "imexv-thesis")) {
    const double theirs = session.thesis.run(run.model, run.load, run.alpha)->reached;
    const auto seconds = [&](const char* method) {
      run.integrator = method;
      return orbits.at(run.text()).reached;
    };
    const double same = seconds("imexv-thesis"), symmetric = seconds("imexv");
    if (std::min({theirs, same, symmetric}) < thesis::kDuration)
      parts.push_back(fmt::format("{}: thesis {:g} s, imexv-thesis {:.2f} s, imexv {:.2f} s",
                                  where_text(run), theirs, same, symmetric));
  }
  if (parts.empty()) return "No run of imexv breaks off on these models.";
  return fmt::format(
      "Where a run of IMEXv breaks off, here or there: {}. The thesis's force is unknown and the "
      "orbits are chaotic before they break off: a factor changed by a millionth moves beam's "
      "times by a second or two.",
      fmt::join(parts, "; "));
}

// ep4 under the strong loads: its largest drift and its halved steps.
std::string strong_text(const Session& session, const Orbits& orbits) {
  std::int64_t cut = 0, steps = 0;
  double worst = 0.0;
  std::string where;
  for (const double load_multiple : kStrongLoads)
    for (const RunName& run : thesis_runs(session.models, "ep4", load_multiple)) {
      const Orbit& orbit = orbits.at(run.text());
      cut += orbit.cut_steps;
      steps += orbit.steps;
      if (where.empty() || orbit.energy_drift > worst) {
        worst = orbit.energy_drift;
        where = fmt::format("{}, loads times {:g}", where_text(run), load_multiple);
      }
    }
  return fmt::format(
      "The largest error of ep4's energy balance is {:.2g} ({}); {} of its {} steps were taken in "
      "parts.",
      worst, where, cut, steps);
}

// "36 of 36", or which runs did not and why.
Criterion strong_criterion(const Session& session, const Orbits& orbits, double load_multiple) {
  const Survivors count = count_survivors(session, orbits, "ep4", load_multiple);
  std::string measured = fmt::format("{} of {}", count.reached, count.of);
  bool explained = true;
  for (const RunName& run : thesis_runs(session.models, "ep4", load_multiple)) {
    const Orbit& orbit = orbits.at(run.text());
    if (orbit.finished()) continue;
    measured += fmt::format("; {}: {:.2f} s, {}", where_text(run), orbit.reached, orbit.reason);
    explained = explained && !orbit.reason.empty();
  }
  return {fmt::format("ep4, loads times {:g}: runs that reach 30 s", load_multiple),
          fmt::format("{} of {}, or why not", count.of, count.of), measured, explained};
}

void add_strong_loads(Report& report, const Session& session, const Orbits& orbits,
                      std::vector<Criterion>& criteria) {
  report.heading("Loads times 3 and 10");
  std::vector<std::string> counts;
  for (const double load_multiple : kStrongLoads)
    for (const std::string method : kStrongMethods) {
      const Survivors one = count_survivors(session, orbits, method, load_multiple);
      counts.push_back(
          fmt::format("x{:g} {} {} of {}", load_multiple, method, one.reached, one.of));
    }
  report.paragraph(
      fmt::format("The same runs pushed harder still. Runs that reach 30 s: {}. {} The thesis has "
                  "no such runs.",
                  fmt::join(counts, ", "), strong_text(session, orbits)));
  report.table(strong_reached_table(session, orbits),
               "Seconds reached of 30; * broke off. What else was measured, and why a run ended, "
               "is in `strong-loads.csv`.",
               {}, 3);
  report.file(strong_runs_table(session, orbits), "strong-loads.csv");
  for (const double load_multiple : kStrongLoads)
    criteria.push_back(strong_criterion(session, orbits, load_multiple));
}

// A note on errors in the thesis's table.
std::string table_note(int table) {
  std::string text = fmt::format("Table {}", table);
  if (table == 5)
    return text +
           ". In the thesis this table repeats table 6, caption and all: its numbers are those of "
           "the square load.";
  if (table == 7)
    return text +
           ". In the thesis the Newmark column repeats table 6, and beam and tower have a speed-up "
           "though IMEXv broke off (*).";
  if (table == 6)
    return text + ". In the thesis table 5 and the Newmark column of table 7 repeat this one.";
  if (table == 10) return text + ". In the thesis beam has a speed-up though IMEXv broke off (*).";
  return text + ".";
}

// Ours and the thesis's over the six models, runs that reached 30 s in both.
std::string timing_difference(const Session& session, SignalKind load, double alpha,
                              const Orbits& orbits, const Timings& timings) {
  std::vector<double> ours, theirs, iterations, their_iterations;
  for (const SampleModel& model : session.models) {
    const thesis::Run& printed = *session.thesis.run(model.name, load, alpha);
    const std::string imexv = RunName{model.name, "imexv", load, alpha}.text();
    const std::string newmark = RunName{model.name, "newmark", load, alpha}.text();
    if (!orbits.at(imexv).finished() || !printed.finished()) continue;
    ours.push_back(timings.at(newmark).per_step() / timings.at(imexv).per_step());
    theirs.push_back(printed.speedup);
    iterations.push_back(orbits.at(newmark).iterations_per_step /
                         orbits.at(imexv).iterations_per_step);
    their_iterations.push_back(printed.newmark_iterations / printed.imexv_iterations);
  }
  if (ours.empty()) return "";
  return fmt::format(
      " Medians: speed-up {:.2f} in the thesis, {:.2f} here; Newmark solves {:.2f} systems for one "
      "of IMEXv's there, {:.2f} here, where both go on to the same residual.",
      median(theirs), median(ours), median(their_iterations), median(iterations));
}

}  // namespace

void add_modes(Report& report, const Session& session) {
  const Table table = modes_table(session);
  const auto same = std::ranges::count_if(
      table.rows, [](const std::vector<std::string>& row) { return row[3] == row[4]; });
  report.section("Table 1: low and high modes at 3 ms");
  report.paragraph(fmt::format(
      "Ours: explicit iff h omega < 1.8 (stability needs 2). It gives the thesis's counts on {} of "
      "{} models. The thesis's printed rule f < 1/h is no stability limit and cannot have given "
      "its counts on models like ours: see the last column.",
      same, table.rows.size()));
  report.table(table, {}, "table-1.csv");
}

std::vector<Survivors> add_reached(Report& report, const Session& session, const Orbits& orbits,
                                   std::vector<Criterion>& criteria) {
  report.section("Table 3: how far the 36 runs come");
  report.paragraph(fmt::format(
      "Impulse (3 ms), square (0.3 s) and sine (1 Hz) at the model's default load times a factor, "
      "without damping and with alpha = 0.3, h = 3 ms, 30 s. The thesis gives no forces. For beam "
      "and tower the sine's factor is the one at which `imexv` with its fixed split breaks off "
      "most nearly when the thesis's does: tower at {:g}; beam at {:g}, where no factor gives both "
      "6.86 s undamped and 7.12 s damped: those that break off damped after 7 s break off undamped "
      "after 2 to 3 s. All other factors are 1. * marks a run that broke off: the solver gave up, "
      "or the energy exceeded ten times all that was put in.",
      load_factor("tower", SignalKind::kSine), load_factor("beam", SignalKind::kSine)));
  std::vector<Survivors> survivors = {thesis_survivors(session)};
  for (const std::string method : kMethods)
    survivors.push_back(count_survivors(session, orbits, method));
  report.table(survivors_table(survivors), "How many of the runs reach the end.");
  report.table(reached_table(session, orbits), "Table 3. Seconds reached of 30; * broke off.",
               "table-3.csv", 2);
  report.paragraph(reached_difference(session, orbits));
  for (const Survivors& one : survivors)
    if (one.method == "ep4" || one.method == "imexv-adaptive")
      criteria.push_back(
          {fmt::format("{}: runs that reach 30 s", one.method),
           fmt::format("{} of {} (thesis: {})", one.of, one.of, survivors.front().reached),
           fmt::format("{} of {}", one.reached, one.of), one.reached == one.of});
  add_strong_loads(report, session, orbits, criteria);
  return survivors;
}

void add_timings(Report& report, const Session& session, const Orbits& orbits,
                 const Timings& timings) {
  report.section("Tables 5-10: run time");
  report.paragraph(fmt::format(
      "Seconds for the run (30 s, 10 000 steps), linear systems solved a step, and the speed-up "
      "Newmark / IMEXv. The thesis: Core i5-760, MKL. Ours: step() alone, one thread, the smallest "
      "of three, the methods by turns. Both solvers converge to the same relative residual, {:g} "
      "(imexv-thesis: absolute, in units of q). Runs marked * broke off: their seconds are for the "
      "steps they made; our speed-up is always per step.",
      kTolerance));
  for (const double alpha : thesis::kAlphas)
    for (const SignalKind load : thesis::kLoads) {
      const int number = session.thesis.run("beam", load, alpha)->table;
      report.heading(fmt::format("Table {}: {}, {}", number, thesis::load_name(load),
                                 alpha == 0.0 ? "no damping" : "alpha = 0.3"));
      report.table(timing_table(session, load, alpha, orbits, timings),
                   table_note(number) + timing_difference(session, load, alpha, orbits, timings),
                   fmt::format("table-{}.csv", number));
    }
  report.paragraph(
      "Where our speed-ups are smaller than the thesis's: a step of ours costs evaluations of the "
      "polynomial more than linear systems. One contraction gives Newmark force and tangent "
      "together, so that splitting saves only the high rows' smaller system, while imexv evaluates "
      "the low rows' force besides. Of the thesis's Newmark it is said only that it is Barbic's "
      "code.");
  report.heading("All methods");
  report.table(all_timings_table(session, timings, orbits),
               "Microseconds and iterations a step; * broke off.", "timings.csv", 2);
}

void add_energies(Report& report, const Session& session, const Orbits& orbits) {
  report.section("Figures 13-16 and 22-35: energy over time");
  report.paragraph(
      "As the thesis arranges them: IMEXv left, Newmark right, below them the same with damping; "
      "ep4 is drawn over both, dashed. The thesis prints pictures only, so there are no values to "
      "put beside ours. A curve that leaves its frame is a run that breaks off.");
  add_energy_figures(report, session, orbits);
  report.heading("The same runs in numbers");
  report.table(
      energies_table(session, orbits),
      "Mean energy after the load has ended, of the whole run if it lasts, and the largest error "
      "of the energy balance (energy_drift_max in docs/reference.md); * broke off.",
      "energies.csv", 2);
}

}  // namespace tremolo::reproduce
