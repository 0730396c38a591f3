#include "tests/lab/cloth/cloth_sections.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

#include <fmt/format.h>

#include "runtime/step/nodal_integrator.h"
#include "tests/lab/cloth/cloth_study.h"
#include "tests/lab/work/progress.h"

namespace tremolo::cloth_study {
namespace {

constexpr std::array kStiffnesses = {30.0, 300.0, 3000.0};  // N/m
constexpr std::array kParts = {1, 2, 4, 10, 33, 100, 333};  // steps a frame of 1/30 s
constexpr double kStudyDamping = 0.005;                     // N s/m
// Parts of the reference: h omega_max is 0.7 for the stiffest sheet.
constexpr int kReferenceParts = 3000;
// Predicted and observed limits may differ so much: the observed one is a growth within 4000 steps,
// which sets in a little beyond the limit.
constexpr double kLimitBound = 0.03;

struct Case {
  CaseSpec spec;
  StudyOrbit orbit;
  double error = 0.0;
};

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const double stiffness : kStiffnesses)
    for (const std::string_view method : nodal_integrator_names())
      for (const int parts : kParts)
        cases.push_back(
            {{std::string(method), {.stiffness = stiffness, .damping = kStudyDamping}, parts},
             {},
             0.0});
  return cases;
}

// The shortest steps first: they last longest.
void run_cases(std::vector<Case>& cases, unsigned threads) {
  std::vector<Case> truths;
  for (const double stiffness : kStiffnesses)
    truths.push_back(
        {{"rk4", {.stiffness = stiffness, .damping = kStudyDamping}, kReferenceParts}, {}, 0.0});
  for_all("fine references", truths.size(), threads,
          [&](std::size_t i) { truths[i].orbit = run_case(truths[i].spec); });
  std::vector<std::size_t> order(cases.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order, std::greater<>{},
                           [&](std::size_t i) { return cases[i].spec.parts; });
  for_all("methods x steps x stiffnesses", cases.size(), threads, [&](std::size_t i) {
    Case& one = cases[order[i]];
    one.orbit = run_case(one.spec);
    for (const Case& truth : truths)
      if (truth.spec.sheet.stiffness == one.spec.sheet.stiffness)
        one.error = distance(one.orbit, truth.orbit);
    one.orbit.positions.clear();
  });
}

bool reached_end(const Case& one) {
  return one.orbit.why.empty();
}

Table study_table(const std::vector<Case>& cases) {
  Table table{
      {"stiffness N/m", "method", "step s", "reached s", "error m", "energy change J", "damped J",
       "by the method J", "ms a second", "iterations a step", "steps cut", "ended by"},
      {}};
  for (const Case& one : cases)
    table.rows.push_back({cell(one.spec.sheet.stiffness), one.spec.method, cell(one.spec.step()),
                          cell(one.orbit.reached), cell(one.error, 3), cell(one.orbit.energy, 3),
                          cell(one.orbit.damped, 3), cell(one.orbit.numerical, 3),
                          cell(1e3 * one.orbit.seconds, 3), cell(one.orbit.iterations, 3),
                          std::to_string(one.orbit.cut_steps), one.orbit.why});
  return table;
}

CellChart reached_chart(const std::vector<Case>& cases, double stiffness) {
  CellChart chart;
  chart.title = fmt::format("{:g} N/m", stiffness);
  chart.x_label = "step";
  for (const int parts : kParts)
    chart.columns.push_back(fmt::format("{:.3g} ms", 1e3 / (kFrameRate * parts)));
  chart.classes = {{"reaches the end", "#2a9d8f"}, {"breaks off or explodes", "#c8553d"}};
  for (const std::string_view method : nodal_integrator_names()) {
    chart.rows.emplace_back(method);
    chart.values.emplace_back();
    for (const Case& one : cases)
      if (one.spec.sheet.stiffness == stiffness && one.spec.method == method)
        chart.values.back().push_back(reached_end(one) ? 0 : 1);
  }
  return chart;
}

// y of every method over x, both of a case.
template <class X, class Y>
Chart curves_of(const std::vector<Case>& cases, double stiffness, const X& x, const Y& y) {
  Chart chart;
  chart.title = fmt::format("{:g} N/m", stiffness);
  chart.log_x = chart.log_y = true;
  for (const std::string_view method : nodal_integrator_names()) {
    Curve curve{.label = std::string(method), .style = CurveStyle::kLinesAndPoints};
    for (const Case& one : cases) {
      if (one.spec.sheet.stiffness != stiffness || one.spec.method != method) continue;
      if (!reached_end(one)) continue;
      curve.x.push_back(x(one));
      curve.y.push_back(y(one));
    }
    chart.curves.push_back(std::move(curve));
  }
  return chart;
}

void add_figures(Report& report, const std::vector<Case>& cases) {
  std::vector<CellChart> reached;
  std::vector<Chart> errors, costs, energies;
  const auto step = [](const Case& one) { return one.spec.step(); };
  const auto error = [](const Case& one) { return one.error; };
  const auto cost = [](const Case& one) { return 1e3 * one.orbit.seconds; };
  const auto lost = [](const Case& one) { return std::abs(one.orbit.numerical); };
  for (const double stiffness : kStiffnesses) {
    reached.push_back(reached_chart(cases, stiffness));
    errors.push_back(curves_of(cases, stiffness, step, error));
    costs.push_back(curves_of(cases, stiffness, cost, error));
    energies.push_back(curves_of(cases, stiffness, step, lost));
    errors.back().x_label = energies.back().x_label = "step, s";
    costs.back().x_label = "ms of processor time a simulated second";
    errors.back().y_label = costs.back().y_label = "error, m";
    energies.back().y_label = "energy by the method itself, J";
  }
  report.figure(reached, "Which method reaches the end of half a second at which step.");
  report.figure(errors, 3, 340, "Largest distance from the reference over the step.");
  report.figure(costs, 3, 340, "The same over what it costs.");
  report.figure(energies, 3, 340,
                "What the method itself adds to the energy or takes from it in half a second; of "
                "`energy` it is rounding.");
}

}  // namespace

std::vector<Criterion> add_cloth_limits(Report& report, unsigned threads) {
  struct Row {
    std::string method;
    SheetSpec sheet;
    ObservedLimit limit;
  };
  std::vector<Row> rows;
  for (const std::string method : {"symplectic-euler", "rk4", "implicit-euler-sweep"})
    for (const auto& [edge, stiffness] : {std::pair{8, 30.0}, {16, 300.0}, {24, 3000.0}})
      rows.push_back(
          {method,
           {.edge = static_cast<std::size_t>(edge), .stiffness = stiffness, .held = false},
           {}});
  for_all("limits of stability", rows.size(), threads,
          [&](std::size_t i) { rows[i].limit = find_limit(rows[i].method, rows[i].sheet); });
  Table table{{"method", "particles", "stiffness N/m", "predicted ms", "observed ms", "apart %"},
              {}};
  double worst = 0.0;
  for (const Row& row : rows) {
    const double apart = row.limit.observed / row.limit.predicted - 1.0;
    if (row.method != "implicit-euler-sweep") worst = std::max(worst, std::abs(apart));
    table.rows.push_back({row.method, std::to_string(row.sheet.edge * row.sheet.edge),
                          cell(row.sheet.stiffness), cell(1e3 * row.limit.predicted),
                          cell(1e3 * row.limit.observed), cell(100.0 * apart, 2)});
  }
  report.section("Cloth: where explicit methods end");
  report.paragraph(
      "A free sheet at rest, without damping and gravity, is disturbed by a billionth of its "
      "spacing. Predicted: the method's stability number over omega_max, from the sheet's own "
      "stiffness by Lanczos. Observed: the largest step at which the disturbance has not grown a "
      "million times in 4000 steps.");
  report.table(table, "Limits of stability.", "cloth-limits.csv", 1);
  return {at_most("cloth: observed against predicted limits of symplectic-euler and rk4, apart",
                  worst, kLimitBound)};
}

std::vector<Criterion> add_cloth_sections(Report& report, unsigned threads) {
  std::vector<Case> cases = all_cases();
  run_cases(cases, threads);
  report.section("Cloth: every integrator on one sheet");
  report.paragraph(fmt::format(
      "16 x 16 particles over 0.75 m of 0.2 kg/m^2, fixed at two corners and released from the "
      "level, "
      "for half a second; shear a third, bend a hundredth of the structural stiffness, {:g} N s/m "
      "of damping. Errors are the largest root mean square of the particles' distances, over "
      "frames of 1/30 s, from rk4 at 1/{} s.",
      kStudyDamping, static_cast<int>(kFrameRate) * kReferenceParts));
  add_figures(report, cases);
  const Table table = study_table(cases);
  report.table(table, "All runs.", "cloth-study.csv", 2);
  std::vector<Criterion> criteria;
  const std::vector<std::string> lasting = {
      "implicit-euler", "implicit-euler-linear", "midpoint", "newmark", "bdf2", "energy"};
  const auto broken = std::ranges::count_if(cases, [&](const Case& one) {
    return !reached_end(one) && std::ranges::find(lasting, one.spec.method) != lasting.end();
  });
  criteria.push_back(at_most("cloth: implicit methods that break off at any step up to 1/30 s",
                             static_cast<double>(broken), 0.0));
  for (const Criterion& criterion : add_cloth_limits(report, threads))
    criteria.push_back(criterion);
  for (const Criterion& criterion : add_cloth_speed(report)) criteria.push_back(criterion);
  report.criteria(criteria);
  return criteria;
}

}  // namespace tremolo::cloth_study
