#include "runtime/program/reproduce/tables.h"

#include <algorithm>

#include <fmt/format.h>

#include "runtime/program/reproduce/loads.h"
#include "runtime/program/reproduce/thesis.h"
#include "runtime/split.h"

namespace tremolo::reproduce {
namespace {

std::string damping_name(double alpha) {
  return alpha == 0.0 ? "none" : fmt::format("alpha = {:g}", alpha);
}

std::string factor_text(std::string_view model, SignalKind load) {
  const double factor = load_factor(model, load);
  return factor == 1.0 ? std::string("1") : fmt::format("{:g}", factor);
}

std::string reached_text(const Orbit& orbit) {
  return orbit.finished() ? cell(orbit.reached) : fmt::format("{:.2f}*", orbit.reached);
}

std::string marked(double value, bool finished, int digits = 2) {
  return fmt::format("{:.{}f}{}", value, digits, finished ? "" : "*");
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::ranges::sort(values);
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

}  // namespace

Survivors count_survivors(const Workshop& shop, const Orbits& orbits, const std::string& method,
                          double another) {
  Survivors survivors{method};
  for (const RunName& run : the_runs(shop.models, method, another)) {
    ++survivors.of;
    if (orbits.at(run.text()).finished()) ++survivors.reached;
  }
  return survivors;
}

Table modes_table(const std::vector<SampleModel>& models) {
  Table table{{"model", "r, thesis", "r, ours", "low, thesis", "low, ours", "high, thesis",
               "high, ours", "low by f < 1/h, ours"},
              {}};
  for (const SampleModel& model : models) {
    const thesis::Modes& theirs = *thesis::modes(model.name);
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

Table reached_table(const Workshop& shop, const Orbits& orbits) {
  Table table{{"damping", "load", "method"}, {}};
  for (const SampleModel& model : shop.models) table.columns.push_back(model.name);
  for (const double alpha : thesis::kAlphas)
    for (const SignalKind load : thesis::kLoads) {
      const std::string load_text(thesis::load_name(load));
      std::vector<std::string> factors{damping_name(alpha), load_text, "factor on our load"};
      std::vector<std::string> theirs{damping_name(alpha), load_text, "thesis, IMEXv"};
      for (const SampleModel& model : shop.models) {
        factors.push_back(factor_text(model.name, load));
        const double reached = thesis::run(model.name, load, alpha)->reached;
        theirs.push_back(reached < thesis::kDuration ? fmt::format("{:.2f}*", reached)
                                                     : cell(reached));
      }
      table.rows.push_back(std::move(factors));
      table.rows.push_back(std::move(theirs));
      for (const std::string& method : methods()) {
        std::vector<std::string> row{damping_name(alpha), load_text, method};
        for (const SampleModel& model : shop.models)
          row.push_back(reached_text(orbits.at(RunName{model.name, method, load, alpha}.text())));
        table.rows.push_back(std::move(row));
      }
    }
  return table;
}

Table strong_loads_table(const Workshop& shop, const Orbits& orbits) {
  Table table{{"loads", "model", "load", "damping", "method", "reached, s", "iterations a step",
               "steps cut", "drift", "why not"},
              {}};
  for (const double another : {3.0, 10.0})
    for (const char* method : {"ep4", "imexv"})
      for (RunName run : the_runs(shop.models, method, another)) {
        const auto found = orbits.find(run.text());
        if (found == orbits.end()) continue;
        const Orbit& orbit = found->second;
        table.rows.push_back({fmt::format("x{:g}", another), run.model,
                              std::string(thesis::load_name(run.load)), damping_name(run.alpha),
                              method, reached_text(orbit), cell(orbit.iterations_per_step, 3),
                              fmt::format("{}", orbit.cut_steps), cell(orbit.energy_drift, 2),
                              orbit.reason});
      }
  return table;
}

Table timing_table(const Workshop& shop, SignalKind load, double alpha, const Orbits& orbits,
                   const Timings& timings) {
  Table table{{"model", "IMEXv s, thesis", "imexv s, ours", "Newmark s, thesis", "newmark s, ours",
               "IMEXv it., thesis", "imexv it., ours", "Newmark it., thesis", "newmark it., ours",
               "speed-up, thesis", "speed-up, ours", "ours / thesis"},
              {}};
  for (const SampleModel& model : shop.models) {
    const thesis::Run& theirs = *thesis::run(model.name, load, alpha);
    const std::string imexv = RunName{model.name, "imexv", load, alpha}.text();
    const std::string newmark = RunName{model.name, "newmark", load, alpha}.text();
    const bool they_finished = theirs.reached >= thesis::kDuration;
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

Table all_timings_table(const Workshop& shop, const Timings& timings, const Orbits& orbits) {
  Table table{{"damping", "load", "model"}, {}};
  for (const std::string& method : methods()) table.columns.push_back(method + ", us a step");
  for (const std::string& method : methods()) table.columns.push_back(method + ", it.");
  for (const RunName& run : the_runs(shop.models, "")) {
    std::vector<std::string> row{damping_name(run.alpha), std::string(thesis::load_name(run.load)),
                                 run.model};
    std::vector<std::string> iterations;
    for (const std::string& method : methods()) {
      const std::string name = RunName{run.model, method, run.load, run.alpha}.text();
      const Orbit& orbit = orbits.at(name);
      row.push_back(marked(1e6 * timings.at(name).per_step(), orbit.finished()));
      iterations.push_back(marked(orbit.iterations_per_step, orbit.finished()));
    }
    row.insert(row.end(), iterations.begin(), iterations.end());
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table energies_table(const Workshop& shop, const Orbits& orbits) {
  Table table{{"damping", "load", "model"}, {}};
  for (const std::string& method : methods()) table.columns.push_back(method + ", mean J");
  for (const std::string& method : methods()) table.columns.push_back(method + ", balance");
  for (const RunName& run : the_runs(shop.models, "")) {
    std::vector<std::string> row{damping_name(run.alpha), std::string(thesis::load_name(run.load)),
                                 run.model};
    std::vector<std::string> balance;
    for (const std::string& method : methods()) {
      const Orbit& orbit = orbits.at(RunName{run.model, method, run.load, run.alpha}.text());
      row.push_back(orbit.finished() ? cell(orbit.mean_energy) : "*");
      balance.push_back(cell(orbit.energy_drift, 2) + (orbit.finished() ? "" : "*"));
    }
    row.insert(row.end(), balance.begin(), balance.end());
    table.rows.push_back(std::move(row));
  }
  return table;
}

Criterion speedups(const Workshop& shop, const Orbits& orbits, const Timings& timings) {
  std::vector<double> ours, theirs;
  int above = 0;
  for (const RunName& run : the_runs(shop.models, "imexv")) {
    const thesis::Run& printed = *thesis::run(run.model, run.load, run.alpha);
    const std::string newmark = RunName{run.model, "newmark", run.load, run.alpha}.text();
    if (!orbits.at(run.text()).finished() || printed.reached < thesis::kDuration) continue;
    ours.push_back(timings.at(newmark).per_step() / timings.at(run.text()).per_step());
    theirs.push_back(printed.speedup);
    if (ours.back() > 1.0) ++above;
  }
  if (ours.empty())
    return {"speed-up of IMEXv over Newmark", "none", "no run to compare", true, false};
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
