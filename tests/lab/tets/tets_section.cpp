#include "tests/lab/tets/tets_section.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "runtime/program/output/tell.h"
#include "tests/lab/tets/bar_runs.h"

namespace tremolo::tets {
namespace {

constexpr int kCells[] = {1, 2, 3, 4};
constexpr int kReferenceCells = 5;
constexpr double kYoungs[] = {2e5, 1e6};  // Pa
constexpr double kUppers[] = {0.01, 0.002, 0.001};
constexpr double kEqualLook = 0.002;

// One row of the table. error: against the reference; look: against the fully quadratic bar of the
// same mesh.
struct BarRow {
  BarCase what;
  BarRun run;
  double error = 0.0, look = 0.0;
};

std::string bar_name(const BarCase& c) {
  if (c.kind == DegreeKind::kAdaptive) return fmt::format("adaptive, {:g} %", 100.0 * c.upper);
  return c.kind == DegreeKind::kLinear ? "linear" : "quadratic";
}

BarRun stored_bar(const Store& store, const BarCase& c) {
  const nlohmann::json key = {
      {"experiment", "tets-bar"}, {"version", 2},     {"cells", c.cells},   {"young", c.young},
      {"degree", bar_name(c)},    {"lower", c.lower}, {"steps", kBarSteps}, {"step", kBarStep}};
  const std::string name = fmt::format("tets-bar-{}-{:.0f}-{}-{:g}", c.cells, c.young,
                                       static_cast<int>(c.kind), c.upper);
  tell("tremolo: bar of {} cells, {}, {:g} Pa\n", c.cells, bar_name(c), c.young);
  return store.get_as<BarRun>(name, key, [&c] { return run_bar(c); });
}

std::vector<BarRow> bar_rows(const Store& store, double young) {
  const BarRun reference = stored_bar(store, {kReferenceCells, young, DegreeKind::kQuadratic});
  std::vector<BarRow> rows;
  for (const int cells : kCells) {
    const std::size_t first = rows.size();
    rows.push_back({{cells, young, DegreeKind::kQuadratic}, {}, 0.0, 0.0});
    rows.push_back({{cells, young, DegreeKind::kLinear}, {}, 0.0, 0.0});
    for (const double upper : kUppers)
      rows.push_back({{cells, young, DegreeKind::kAdaptive, upper, 0.4 * upper}, {}, 0.0, 0.0});
    for (std::size_t i = first; i < rows.size(); ++i) {
      rows[i].run = stored_bar(store, rows[i].what);
      rows[i].error = bar_error(rows[i].run, reference);
      rows[i].look = bar_error(rows[i].run, rows[first].run);
    }
  }
  return rows;
}

// The error of linear elements at the same time a step, between their meshes on straight lines of
// logarithms; outside of them that of the nearest.
double linear_error_at(const std::vector<BarRow>& rows, double seconds) {
  std::vector<std::pair<double, double>> curve;
  for (const BarRow& row : rows)
    if (row.what.kind == DegreeKind::kLinear)
      curve.emplace_back(std::log(row.run.seconds), std::log(row.error));
  const double t = std::log(seconds);
  if (t <= curve.front().first) return std::exp(curve.front().second);
  for (std::size_t i = 1; i < curve.size(); ++i) {
    const auto& [t0, e0] = curve[i - 1];
    const auto& [t1, e1] = curve[i];
    if (t <= t1) return std::exp(e0 + (e1 - e0) * (t - t0) / (t1 - t0));
  }
  return std::exp(curve.back().second);
}

void add_rows(const std::vector<BarRow>& rows, Table& table) {
  double quadratic = 1.0;
  for (const BarRow& row : rows) {
    if (row.what.kind == DegreeKind::kQuadratic) quadratic = row.run.seconds;
    table.rows.push_back({cell(row.what.young), cell(row.run.elements), bar_name(row.what),
                          cell(1e3 * row.run.seconds / kBarSteps, 3),
                          cell(row.run.seconds / quadratic, 3), cell(100.0 * row.run.share, 3),
                          cell(100.0 * row.error, 3), cell(100.0 * row.look, 3),
                          cell(row.run.switched), cell(row.run.switch_energy, 2),
                          cell(1e-6 * row.run.bytes, 3), cell(row.run.failed)});
  }
}

Criterion saving(const std::vector<BarRow>& rows) {
  double best = std::numeric_limits<double>::infinity(), quadratic = 1.0;
  std::string who = "no threshold looks equal";
  for (const BarRow& row : rows) {
    if (row.what.cells != kCells[3]) continue;
    if (row.what.kind == DegreeKind::kQuadratic) quadratic = row.run.seconds;
    if (row.what.kind != DegreeKind::kAdaptive || row.look > kEqualLook) continue;
    if (row.run.seconds / quadratic >= best) continue;
    best = row.run.seconds / quadratic;
    who = fmt::format("{}, {:.3g} % off", bar_name(row.what), 100.0 * row.look);
  }
  return at_most(fmt::format("fine bar, {:g} Pa: time of adaptive edges over quadratic ones where "
                             "the surface is at most 0.2 % off theirs",
                             rows.front().what.young),
                 best, 0.75, who);
}

Criterion accuracy(const std::vector<BarRow>& rows) {
  double worst = std::numeric_limits<double>::infinity();
  std::string who;
  for (const BarRow& row : rows) {
    if (row.what.kind != DegreeKind::kAdaptive || row.what.upper != kUppers[2]) continue;
    const double ratio = linear_error_at(rows, row.run.seconds) / row.error;
    if (ratio >= worst) continue;
    worst = ratio;
    who = fmt::format("{:.0f} elements", row.run.elements);
  }
  Criterion criterion{fmt::format("bar, {:g} Pa: error of linear elements over that of adaptive "
                                  "ones (0.1 %) at equal time, the smallest of the meshes",
                                  rows.front().what.young),
                      ">= 5", fmt::format("{:.3g} ({})", worst, who), worst >= 5.0};
  return criterion;
}

Criterion never_slower(const std::vector<BarRow>& rows) {
  double worst = 0.0, quadratic = 1.0;
  std::string who;
  for (const BarRow& row : rows) {
    if (row.what.kind == DegreeKind::kQuadratic) quadratic = row.run.seconds;
    if (row.what.kind != DegreeKind::kAdaptive || row.run.seconds / quadratic <= worst) continue;
    worst = row.run.seconds / quadratic;
    who = fmt::format("{:.0f} elements, {}", row.run.elements, bar_name(row.what));
  }
  return at_most(
      fmt::format("bar, {:g} Pa: time of adaptive edges over quadratic ones, the largest",
                  rows.front().what.young),
      worst, 1.05, who);
}

}  // namespace

std::vector<Criterion> add_tets_section(Report& report, const Store& store) {
  report.section("Bodies of tetrahedra whose edges choose their degree");
  report.paragraph(fmt::format(
      "A bar held at one end falls under its own weight for {} steps of 1/60 s, `bdf2`. Error: of "
      "17 x 3 x 3 points over all steps, root mean square, in % of the length, against a quadratic "
      "bar of {} x {} x {} cells; look: the same against the quadratic bar of the same mesh. The "
      "percentage behind `adaptive` is the upper threshold; the lower is 0.4 of it.",
      kBarSteps, 4 * kReferenceCells, kReferenceCells, kReferenceCells));
  Table table{{"E, Pa", "elements", "edges", "ms a step", "over quadratic", "% quadratic",
               "error, %", "look, %", "switches", "J taken", "MB", "not solved"},
              {}};
  std::vector<Criterion> criteria;
  for (const double young : kYoungs) {
    const std::vector<BarRow> rows = bar_rows(store, young);
    add_rows(rows, table);
    criteria.push_back(saving(rows));
    criteria.push_back(accuracy(rows));
    criteria.push_back(never_slower(rows));
  }
  report.table(table, "Processor time of one thread.", "tets-bar.csv", 2);
  report.criteria(criteria);
  return criteria;
}

}  // namespace tremolo::tets
