#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "runtime/apps/tremolo/output/statistics.h"
#include "tests/lab/bench/precision_report.h"

namespace tremolo::bench {
namespace {

std::optional<Cost> cost_in(const Precision& precision, std::size_t scene,
                            const std::string& integrator, double target) {
  return cost_of_error(precision.curve(scene, integrator), target, precision.references[scene].gap);
}

std::string cost_cell(const std::optional<Cost>& cost) {
  if (!cost) return {};
  return (cost->at_most ? "<= " : "") + cell(cost->value, 3);
}

std::string ratio_cell(double ratio) {
  if (std::isinf(ratio)) return "> all";
  return cell(ratio, 3);
}

std::vector<std::string> scene_cells(const Scene& scene) {
  return {scene.subject->sample.name, scene.load, fmt::format("{:g}", scene.amplitude)};
}

}  // namespace

std::string percent(double fraction) {
  return fmt::format("{:g} %", std::stod(fmt::format("{:.3g}", 100.0 * fraction)));
}

Table bench_table(const Precision& precision) {
  Table table{{"model", "load", "amplitude", "scale", "integrator", "step_s", "trajectory_error",
               "below_reference", "horizon_s", "reference_gap", "energy_drift_max",
               "high_band_ratio", "iterations_per_step", "reached_s", "exit_code", "reason",
               "microseconds_per_step", "ms_per_simulated_s"},
              {}};
  for (const Entry& e : precision.entries) {
    const Reference& reference = precision.references[e.scene];
    std::vector<std::string> row = scene_cells(precision.scenes[e.scene]);
    for (std::string text :
         {cell(precision.scenes[e.scene].scale, 6), e.integrator, cell(e.step, 6), cell(e.error, 6),
          std::string(e.below_reference ? "yes" : "no"), cell(reference.seconds, 6),
          cell(reference.gap), cell(e.drift), cell(e.band_ratio, 6), cell(e.iterations),
          cell(e.reached, 6), fmt::format("{}", e.exit_code), e.reason, cell(e.microseconds),
          cell(e.cost())})
      row.push_back(std::move(text));
    table.rows.push_back(std::move(row));
  }
  for (std::size_t i = 0; i < precision.scenes.size(); ++i) {
    if (precision.measured(i)) continue;
    std::vector<std::string> row = scene_cells(precision.scenes[i]);
    row.resize(table.columns.size());
    row[15] = precision.scenes[i].usable() ? precision.references[i].trouble
                                           : precision.scenes[i].trouble;
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table scene_table(const Precision& precision) {
  Table table{{"model", "load", "amplitude", "times the default load", "references agree until (s)",
               "gap until then", "largest gap", "remark"},
              {}};
  for (std::size_t i = 0; i < precision.scenes.size(); ++i) {
    const Scene& scene = precision.scenes[i];
    const Reference& reference = precision.references[i];
    std::vector<std::string> row = scene_cells(scene);
    if (scene.usable())
      row.insert(row.end(), {cell(scene.scale), cell(reference.seconds), cell(reference.gap, 2),
                             cell(reference.worst_gap, 2), reference.trouble});
    else
      row.insert(row.end(), {"", "", "", "", scene.trouble});
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table cost_table(const Precision& precision) {
  Table table{{"model", "load", "amplitude", "integrator"}, {}};
  for (const double target : kTargets)
    table.columns.push_back(fmt::format("ms_per_simulated_s_to_{:g}", target));
  for (std::size_t i = 0; i < precision.scenes.size(); ++i)
    for (const std::string& integrator : precision.integrators) {
      if (!precision.measured(i)) continue;
      std::vector<std::string> row = scene_cells(precision.scenes[i]);
      row.push_back(integrator);
      for (const double target : kTargets)
        row.push_back(cost_cell(cost_in(precision, i, integrator, target)));
      table.rows.push_back(std::move(row));
    }
  return table;
}

Table cost_matrix(const Precision& precision, const std::string& load, double target) {
  Table table{{"model", "amplitude"}, {}};
  table.columns.insert(table.columns.end(), precision.integrators.begin(),
                       precision.integrators.end());
  table.columns.push_back("best");
  for (std::size_t i = 0; i < precision.scenes.size(); ++i) {
    const Scene& scene = precision.scenes[i];
    if (scene.load != load || !precision.measured(i)) continue;
    std::vector<std::string> row = {scene.subject->sample.name, percent(scene.amplitude)};
    std::string best = "none";
    double least = std::numeric_limits<double>::infinity();
    for (const std::string& integrator : precision.integrators) {
      const std::optional<Cost> cost = cost_in(precision, i, integrator, target);
      row.push_back(cost_cell(cost));
      if (cost && cost->value < least) best = integrator, least = cost->value;
    }
    row.push_back(best);
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table ratio_table(const Precision& precision) {
  Table table{{"integrator"}, {}};
  std::vector<std::string> peers;
  for (const char* peer : {"newmark", "imexv", "verlet", "verlet4"})
    if (std::ranges::find(precision.integrators, peer) != precision.integrators.end())
      peers.push_back(peer);
  for (const double target : kTargets)
    for (const std::string& peer : peers) table.columns.push_back(peer + ", " + percent(target));
  for (const std::string& integrator : precision.integrators) {
    std::vector<std::string> row = {integrator};
    for (const double target : kTargets)
      for (const std::string& peer : peers)
        row.push_back(integrator == peer
                          ? std::string("1")
                          : ratio_cell(median(cost_ratios(precision, integrator, peer, target))));
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table standing_table(const Precision& precision, double target) {
  Table table{{"integrator", "reaches it in", "of", "fastest in", "cost over the best's, median"},
              {}};
  for (const Standing& s : standings(precision, target))
    table.rows.push_back({s.integrator, fmt::format("{}", s.reached), fmt::format("{}", s.scenes),
                          fmt::format("{}", s.wins), cell(s.slowdown, 3)});
  return table;
}

}  // namespace tremolo::bench
