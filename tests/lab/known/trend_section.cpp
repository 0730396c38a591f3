#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "runtime/program/output/statistics.h"
#include "tests/lab/known/energy_trend.h"
#include "tests/lab/known/quartic_model.h"
#include "tests/lab/known/sections.h"
#include "tests/lab/known/step_properties.h"
#include "tests/lab/report/chart.h"

namespace tremolo::known {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kMethods[] = {"midpoint",      "newmark", "imexv", "imexv-linear",
                                         "imexv-coupled", "avf",     "ep2",   "ep4",
                                         "verlet",        "verlet4"};
constexpr double kTolerances[] = {1e-6, 1e-9, 1e-12};
constexpr double kStep = 1e-3;  // s
constexpr int kWindows = 100;
constexpr double kDriftBound = 1e-9;

Result<EnergyTrend> stored_trend(const SectionContext& context, std::string_view method,
                                 double tolerance) {
  const long steps = context.long_form ? 1000000 : 100000;
  const Json key = {{"experiment", "trend"},  {"version", 1},  {"method", std::string(method)},
                    {"tolerance", tolerance}, {"step", kStep}, {"steps", steps},
                    {"windows", kWindows}};
  const Result<Json> json = context.store.get(
      fmt::format("known-trend-{}-{:.0e}", method, tolerance), key, [&]() -> Result<Json> {
        const Result<EnergyTrend> t = measure_trend(method, tolerance, kStep, steps, kWindows);
        if (!t) return t.error();
        return Json{{"reached", t->reached},      {"slope", t->slope},
                    {"error", t->standard_error}, {"largest", t->largest},
                    {"implicit", t->implicit},    {"failure", t->failure},
                    {"means", t->window_means}};
      });
  if (!json) return json.error();
  EnergyTrend trend;
  trend.method = method;
  trend.tolerance = tolerance;
  trend.steps = steps;
  trend.reached = (*json)["reached"].get<long>();
  trend.slope = to_number((*json)["slope"]);
  trend.standard_error = to_number((*json)["error"]);
  trend.largest = to_number((*json)["largest"]);
  trend.implicit = (*json)["implicit"].get<bool>();
  trend.failure = (*json)["failure"].get<std::string>();
  for (const Json& mean : (*json)["means"]) trend.window_means.push_back(to_number(mean));
  return trend;
}

// The window means over thousands of steps, less the mean of all if `centred`.
Curve means_curve(const EnergyTrend& trend, bool centred) {
  Curve curve{.label = trend.method, .y = trend.window_means};
  const double middle = mean(curve.y);
  for (std::size_t k = 0; k < curve.y.size(); ++k) {
    curve.x.push_back(1e-3 * (static_cast<double>(k) + 0.5) * static_cast<double>(trend.steps) /
                      kWindows);
    if (centred) curve.y[k] -= middle;
  }
  return curve;
}

}  // namespace

Criteria add_trend_section(const SectionContext& context) {
  context.page.section("Known answers: the trend of the energy");
  context.page.paragraph(fmt::format(
      "The same chain from half that state, h = 1 ms (h omega = 0.23, 0.44, 0.70), free and "
      "undamped, "
      "{} steps. H is averaged over {} windows and a line fitted through the means: its rise over "
      "the "
      "whole run, relative to H, with its standard error. The error takes the windows as "
      "independent; "
      "slow beats make it somewhat too small. The solver's tolerance is the control: a drift that "
      "follows it is the solver's, one that does not is the method's or rounding's.",
      context.long_form ? "a million" : "a hundred thousand", kWindows));
  Table table{{"method", "tolerance", "drift over the run", "standard error", "drift / error",
               "max |H - H0| / H0", "failure"},
              {}};
  Chart bounded{.title = "methods with a modified energy: mean of each window less that of all",
                .x_label = "thousand steps",
                .y_label = "H/H0"};
  Chart kept{.title = "methods that keep H: mean of each window",
             .x_label = "thousand steps",
             .y_label = "H/H0 - 1"};
  std::vector<Criterion> criteria;
  for (const std::string_view method : kMethods) {
    const std::optional<Promise> promise = promise_of(method);
    for (const double tolerance : kTolerances) {
      const Result<EnergyTrend> trend = stored_trend(context, method, tolerance);
      if (!trend) return trend.error();
      table.rows.push_back({trend->method, trend->implicit ? cell(tolerance, 1) : "none",
                            cell(trend->slope, 3), cell(trend->standard_error, 2),
                            cell(trend->slope / trend->standard_error, 2), cell(trend->largest, 2),
                            trend->failure});
      const bool last = !trend->implicit || tolerance == kTolerances[2];
      if (last) {
        const bool keeps = promise && promise->energy;
        (keeps ? kept : bounded).curves.push_back(means_curve(*trend, !keeps));
      }
      if (promise && promise->energy && last)
        criteria.push_back(
            at_most(fmt::format("energy trend, {}: drift over {} steps at tolerance 1e-12", method,
                                trend->steps),
                    trend->failure.empty() ? std::abs(trend->slope)
                                           : std::numeric_limits<double>::quiet_NaN(),
                    kDriftBound));
      else if (last) {
        Criterion shown = at_most(fmt::format("energy trend, {}: drift in standard errors", method),
                                  std::abs(trend->slope / trend->standard_error), 4.0);
        shown.decides = false;
        criteria.push_back(std::move(shown));
      }
      if (!trend->implicit) break;
    }
  }
  if (Status s = add_table(context, table, "known-trend.csv", "Fitted drift of H."); !s)
    return s.error();
  std::vector<Chart> charts{bounded};
  if (!kept.curves.empty()) charts.push_back(kept);
  const Result<std::string> svg = draw_svg(charts, 2, 520, 320);
  if (!svg) return svg.error();
  context.page.figure(*svg, "Means of the hundred windows at tolerance 1e-12. The scales differ.");
  return criteria;
}

}  // namespace tremolo::known
