#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "runtime/apps/tremolo/output/statistics.h"
#include "runtime/split.h"
#include "tests/lab/reproduce/sections.h"

namespace tremolo::reproduce {
namespace {

constexpr const char* kDamping = "damping alpha, 1/s";

std::string damping_cell(double alpha) {
  return fmt::format("{:g}", alpha);
}

std::string reached_cell(double reached, bool finished) {
  return finished ? cell(reached) : fmt::format("{:.2f}*", reached);
}

// Adds a row of the seconds reached, with one cell for each model.
void add_reached_row(Table& table, std::vector<std::string> row, const Session& session,
                     const Orbits& orbits, RunName run) {
  for (const SampleModel& model : session.models) {
    run.model = model.name;
    const Orbit& orbit = orbits.at(run.text());
    row.push_back(reached_cell(orbit.reached, orbit.finished()));
  }
  table.rows.push_back(std::move(row));
}

std::string marked(double value, bool finished, int digits = 2) {
  return fmt::format("{:.{}f}{}", value, digits, finished ? "" : "*");
}

// The 36 runs, two columns a method: first all of the first kind, then all of the second.
// cells(name of the run, orbit) gives one of each.
template <class Cells>
Table methods_table(const Session& session, const Orbits& orbits, const std::string& first,
                    const std::string& second, const Cells& cells) {
  Table table{{kDamping, "load", "model"}, {}};
  for (const std::string& kind : {first, second})
    for (const std::string method : kMethods) table.columns.push_back(method + ", " + kind);
  for (RunName run : thesis_runs(session.models, "")) {
    std::vector<std::string> row{damping_cell(run.alpha), std::string(thesis::load_name(run.load)),
                                 run.model};
    std::vector<std::string> rest;
    for (const std::string method : kMethods) {
      run.integrator = method;
      std::array<std::string, 2> both = cells(run.text(), orbits.at(run.text()));
      row.push_back(std::move(both[0]));
      rest.push_back(std::move(both[1]));
    }
    row.insert(row.end(), rest.begin(), rest.end());
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace

Survivors count_survivors(const Session& session, const Orbits& orbits, const std::string& method,
                          double load_multiple) {
  Survivors survivors{method};
  for (const RunName& run : thesis_runs(session.models, method, load_multiple)) {
    ++survivors.of;
    if (orbits.at(run.text()).finished()) ++survivors.reached;
  }
  return survivors;
}

Survivors thesis_survivors(const Session& session) {
  Survivors survivors{"thesis"};
  for (const RunName& run : thesis_runs(session.models, "")) {
    ++survivors.of;
    if (session.thesis.run(run.model, run.load, run.alpha)->finished()) ++survivors.reached;
  }
  return survivors;
}

Table survivors_table(const std::vector<Survivors>& list) {
  Table table{{"method", "runs that reach 30 s", "of"}, {}};
  for (const Survivors& one : list)
    table.rows.push_back({one.method, std::to_string(one.reached), std::to_string(one.of)});
  return table;
}

Table modes_table(const Session& session) {
  Table table{{"model", "r, thesis", "r, ours", "low, thesis", "low, ours", "high, thesis",
               "high, ours", "low by f < 1/h, ours"},
              {}};
  for (const SampleModel& model : session.models) {
    const thesis::Modes& theirs = *session.thesis.modes_of(model.name);
    const Eigen::VectorXd& lambda = model.model->lambda();
    const Split ours = *choose_split(lambda, thesis::kStep, {});
    const Split literal = *choose_split(lambda, thesis::kStep, {.rule = SplitRule::kThesis});
    table.rows.push_back({model.name, fmt::format("{}", theirs.r), fmt::format("{}", lambda.size()),
                          fmt::format("{}", theirs.low), fmt::format("{}", ours.low),
                          fmt::format("{}", theirs.high), fmt::format("{}", ours.high),
                          fmt::format("{}", literal.low)});
  }
  return table;
}

Table reached_table(const Session& session, const Orbits& orbits) {
  Table table{{kDamping, "load", "method"}, {}};
  for (const SampleModel& model : session.models) table.columns.push_back(model.name);
  for (const double alpha : thesis::kAlphas)
    for (const SignalKind load : thesis::kLoads) {
      const std::string load_text(thesis::load_name(load));
      std::vector<std::string> theirs{damping_cell(alpha), load_text, "thesis, IMEXv"};
      for (const SampleModel& model : session.models) {
        const thesis::Run& run = *session.thesis.run(model.name, load, alpha);
        theirs.push_back(reached_cell(run.reached, run.finished()));
      }
      table.rows.push_back(std::move(theirs));
      for (const std::string method : kMethods)
        add_reached_row(table, {damping_cell(alpha), load_text, method}, session, orbits,
                        {"", method, load, alpha});
    }
  return table;
}

Table strong_reached_table(const Session& session, const Orbits& orbits) {
  Table table{{"loads times", kDamping, "load", "method"}, {}};
  for (const SampleModel& model : session.models) table.columns.push_back(model.name);
  for (const double load_multiple : kStrongLoads)
    for (const double alpha : thesis::kAlphas)
      for (const SignalKind load : thesis::kLoads)
        for (const std::string method : kStrongMethods)
          add_reached_row(table,
                          {fmt::format("{:g}", load_multiple), damping_cell(alpha),
                           std::string(thesis::load_name(load)), method},
                          session, orbits, {"", method, load, alpha, load_multiple});
  return table;
}

Table strong_runs_table(const Session& session, const Orbits& orbits) {
  Table table{{"loads times", "model", "load", kDamping, "method", "reached, s",
               "iterations a step", "steps in parts", "drift", "why not"},
              {}};
  for (const double load_multiple : kStrongLoads)
    for (const std::string method : kStrongMethods)
      for (const RunName& run : thesis_runs(session.models, method, load_multiple)) {
        const Orbit& orbit = orbits.at(run.text());
        table.rows.push_back(
            {fmt::format("{:g}", load_multiple), run.model,
             std::string(thesis::load_name(run.load)), damping_cell(run.alpha), method,
             reached_cell(orbit.reached, orbit.finished()), cell(orbit.iterations_per_step, 3),
             fmt::format("{}", orbit.cut_steps), cell(orbit.energy_drift, 2), orbit.reason});
      }
  return table;
}

Table timing_table(const Session& session, SignalKind load, double alpha, const Orbits& orbits,
                   const Timings& timings) {
  Table table{{"model", "IMEXv s, thesis", "imexv s, ours", "Newmark s, thesis", "newmark s, ours",
               "IMEXv it., thesis", "imexv it., ours", "Newmark it., thesis", "newmark it., ours",
               "speed-up, thesis", "speed-up, ours", "ours / thesis"},
              {}};
  for (const SampleModel& model : session.models) {
    const thesis::Run& theirs = *session.thesis.run(model.name, load, alpha);
    const std::string imexv = RunName{model.name, "imexv", load, alpha}.text();
    const std::string newmark = RunName{model.name, "newmark", load, alpha}.text();
    const bool they_finished = theirs.finished();
    const bool finished = orbits.at(imexv).finished();
    const double speedup = timings.at(newmark).per_step() / timings.at(imexv).per_step();
    table.rows.push_back(
        {model.name, marked(theirs.imexv_seconds, they_finished),
         marked(timings.at(imexv).seconds, finished, 4), marked(theirs.newmark_seconds, true),
         marked(timings.at(newmark).seconds, orbits.at(newmark).finished(), 4),
         marked(theirs.imexv_iterations, they_finished, 1),
         marked(orbits.at(imexv).iterations_per_step, finished),
         marked(theirs.newmark_iterations, true, 1),
         marked(orbits.at(newmark).iterations_per_step, orbits.at(newmark).finished()),
         marked(theirs.speedup, they_finished), marked(speedup, finished),
         fmt::format("{:.2f}", speedup / theirs.speedup)});
  }
  return table;
}

Table all_timings_table(const Session& session, const Timings& timings, const Orbits& orbits) {
  return methods_table(
      session, orbits, "us a step", "it.",
      [&](const std::string& name, const Orbit& orbit) -> std::array<std::string, 2> {
        return {marked(1e6 * timings.at(name).per_step(), orbit.finished()),
                marked(orbit.iterations_per_step, orbit.finished())};
      });
}

Table energies_table(const Session& session, const Orbits& orbits) {
  return methods_table(session, orbits, "mean J", "balance",
                       [](const std::string&, const Orbit& orbit) -> std::array<std::string, 2> {
                         return {orbit.finished() ? cell(orbit.mean_energy) : "*",
                                 cell(orbit.energy_drift, 2) + (orbit.finished() ? "" : "*")};
                       });
}

Criterion speedups(const Session& session, const Orbits& orbits, const Timings& timings) {
  std::vector<double> ours, theirs;
  int above = 0;
  for (const RunName& run : thesis_runs(session.models, "imexv")) {
    const thesis::Run& printed = *session.thesis.run(run.model, run.load, run.alpha);
    const std::string newmark = RunName{run.model, "newmark", run.load, run.alpha}.text();
    if (!orbits.at(run.text()).finished() || !printed.finished()) continue;
    ours.push_back(timings.at(newmark).per_step() / timings.at(run.text()).per_step());
    theirs.push_back(printed.speedup);
    if (ours.back() > 1.0) ++above;
  }
  if (ours.empty())
    return {"speed-up of imexv over newmark", "shown", "no run to compare", true, false};
  const auto [low, high] = std::ranges::minmax(ours);
  const auto [their_low, their_high] = std::ranges::minmax(theirs);
  return {
      "speed-up of imexv over newmark, runs that reach 30 s",
      fmt::format("thesis: {:.2f} to {:.2f}, median {:.2f}", their_low, their_high, median(theirs)),
      fmt::format("{:.2f} to {:.2f}, median {:.2f}; above 1 in {} of {}", low, high, median(ours),
                  above, ours.size()),
      true, false};
}

}  // namespace tremolo::reproduce
