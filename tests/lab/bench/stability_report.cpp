#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "tests/lab/bench/stability.h"

namespace tremolo::bench {
namespace {

Table all_rows(const std::vector<StabilityCell>& cells) {
  Table table{{"model", "integrator", "scale", "step_s", "outcome", "reached_s", "energy_drift_max",
               "reason"},
              {}};
  for (const StabilityCell& c : cells)
    table.rows.push_back({c.model, c.integrator, cell(c.scale), cell(c.step, 6), name_of(c.outcome),
                          cell(c.reached, 6), cell(c.drift), c.reason});
  return table;
}

std::string mark(const StabilityCell& c) {
  if (c.outcome == Outcome::kSurvives) return {};
  if (c.outcome == Outcome::kDies) return fmt::format("{:.2g} s", c.reached);
  return c.drift < 10.0 ? fmt::format("{:.0f} %", 100.0 * c.drift)
                        : fmt::format("x{:.0f}", c.drift);
}

CellChart map_of(std::span<const StabilityCell> grid, const Options& options) {
  CellChart chart{.title = grid.front().integrator, .x_label = "step (ms)", .y_label = "load"};
  chart.classes = {
      {"survives", "#2b8a5f"}, {"grows", "#f2a93b"}, {"decays", "#8fb8de"}, {"dies", "#a3182d"}};
  for (const double ms : options.stability_steps_ms)
    chart.columns.push_back(fmt::format("{:g}", ms));
  const std::size_t width = chart.columns.size();
  for (std::size_t row = options.stability_scales.size(); row-- > 0;) {  // the largest on top
    chart.rows.push_back(fmt::format("x{:g}", options.stability_scales[row]));
    chart.values.emplace_back();
    chart.marks.emplace_back();
    for (const StabilityCell& c : grid.subspan(row * width, width)) {
      chart.values.back().push_back(static_cast<int>(c.outcome));
      chart.marks.back().push_back(mark(c));
    }
  }
  return chart;
}

Table counts(const std::vector<StabilityCell>& cells, const Options& options) {
  Table table{{"integrator", "survives", "grows", "decays", "dies", "of"}, {}};
  for (const std::string& integrator : options.integrators) {
    std::array<int, 4> count{};
    for (const StabilityCell& c : cells)
      if (c.integrator == integrator) ++count[static_cast<std::size_t>(c.outcome)];
    table.rows.push_back({integrator, fmt::format("{}", count[0]), fmt::format("{}", count[1]),
                          fmt::format("{}", count[2]), fmt::format("{}", count[3]),
                          fmt::format("{}", count[0] + count[1] + count[2] + count[3])});
  }
  return table;
}

}  // namespace

void report_stability(const std::vector<StabilityCell>& cells, const Options& options,
                      Report& report) {
  report.file(all_rows(cells), "stability.csv");
  report.section("Stability: load against step");
  report.paragraph(fmt::format(
      "The model's default square load (0.3 s) times a factor, {:g} s of motion without damping. A "
      "run survives if the energy of the free motion stays within {:.0f} % of what it was when the "
      "load had ended; it grows or decays if it reaches the end with more or less; it dies if the "
      "solver gives up or the energy exceeds ten times all that was put in, at the time that "
      "stands in the cell. The figures in other cells are the largest drift, x for multiples of "
      "the energy. All of it is in `stability.csv`.",
      options.stability_duration, 100.0 * kSurvives));
  report.table(counts(cells, options), "Runs of all models.");
  const std::size_t grid = options.stability_scales.size() * options.stability_steps_ms.size();
  const std::size_t methods = options.integrators.size();
  for (std::size_t first = 0; first < cells.size(); first += grid * methods) {
    std::vector<CellChart> charts;
    for (std::size_t m = 0; m < methods; ++m)
      charts.push_back(map_of(std::span(cells).subspan(first + m * grid, grid), options));
    report.heading(cells[first].model);
    report.figure(charts, "Stability of the " + cells[first].model + ", one map a method.");
  }
}

}  // namespace tremolo::bench
