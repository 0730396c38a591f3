#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "runtime/apps/tremolo/output/statistics.h"
#include "tests/lab/known/energy_trend.h"
#include "tests/lab/known/known_answers.h"
#include "tests/lab/known/step_properties.h"

namespace tremolo::known {

// The stored data of a trend; method, tolerance and steps are in its name and key.
template <class Archive>
void fields(Archive& archive, EnergyTrend& trend) {
  archive("reached", trend.reached, "slope", trend.slope, "error", trend.standard_error, "largest",
          trend.largest, "implicit", trend.implicit, "failure", trend.failure, "means",
          trend.window_means);
}

namespace {

using Json = nlohmann::json;

constexpr std::string_view kMethods[] = {"midpoint",      "newmark", "imexv", "imexv-linear",
                                         "imexv-coupled", "avf",     "ep2",   "ep4",
                                         "verlet",        "verlet4"};
constexpr double kTolerances[] = {1e-6, 1e-9, 1e-12};
constexpr double kTrendStep = 1e-3;  // s
constexpr int kWindows = 100;
constexpr double kDriftBound = 1e-9;

EnergyTrend stored_trend(const Experiments& experiments, std::string_view method,
                         double tolerance) {
  const long steps = experiments.long_form ? 1000000 : 100000;
  const Json key = {{"experiment", "trend"},  {"version", 1},       {"method", std::string(method)},
                    {"tolerance", tolerance}, {"step", kTrendStep}, {"steps", steps},
                    {"windows", kWindows}};
  EnergyTrend trend = experiments.store.get_as<EnergyTrend>(
      fmt::format("known-trend-{}-{:.0e}", method, tolerance), key,
      [&] { return measure_trend(method, tolerance, kTrendStep, steps, kWindows); });
  trend.method = method;
  trend.tolerance = tolerance;
  trend.steps = steps;
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

std::vector<std::string> trend_row(const EnergyTrend& trend) {
  return {trend.method,
          trend.implicit ? cell(trend.tolerance, 1) : "none",
          cell(trend.slope, 3),
          cell(trend.standard_error, 2),
          cell(trend.slope / trend.standard_error, 2),
          cell(trend.largest, 2),
          trend.failure};
}

// A method that keeps H has a bound; for the others the trend is shown.
Criterion judge(const EnergyTrend& trend, bool keeps) {
  if (keeps)
    return at_most(
        fmt::format("energy trend, {}: drift over {} steps at tolerance 1e-12", trend.method,
                    trend.steps),
        trend.failure.empty() ? std::abs(trend.slope) : std::numeric_limits<double>::quiet_NaN(),
        kDriftBound);
  Criterion shown = at_most(fmt::format("energy trend, {}: drift in standard errors", trend.method),
                            std::abs(trend.slope / trend.standard_error), 4.0);
  shown.decides = false;
  return shown;
}

}  // namespace

std::vector<Criterion> add_trend_section(const Experiments& experiments) {
  Report& report = experiments.report;
  report.section("Known answers: the trend of the energy");
  report.paragraph(
      fmt::format("The same chain from half that state, h = 1 ms (h omega = 0.23, 0.44, 0.70), "
                  "free and undamped, {} steps. H is averaged over {} windows and a line fitted "
                  "through the means: its rise over the whole run, relative to H, with its "
                  "standard error. The error takes the windows as independent; slow beats make it "
                  "somewhat too small. The solver's tolerance is the control: a drift that follows "
                  "it is the solver's, one that does not is the method's or rounding's.",
                  experiments.long_form ? "a million" : "a hundred thousand", kWindows));
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
    const bool keeps = promise && promise->energy;
    EnergyTrend trend;
    for (const double tolerance : kTolerances) {
      trend = stored_trend(experiments, method, tolerance);
      table.rows.push_back(trend_row(trend));
      if (!trend.implicit) break;  // no solve: the tolerance changes nothing
    }
    (keeps ? kept : bounded).curves.push_back(means_curve(trend, !keeps));
    criteria.push_back(judge(trend, keeps));
  }
  report.table(table, "Fitted drift of H.", "known-trend.csv");
  report.figure({bounded, kept}, 2, 320,
                "Means of the hundred windows at tolerance 1e-12. The scales differ.");
  return criteria;
}

}  // namespace tremolo::known
