#include "runtime/program/reproduce/experiment3.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "common/parallel.h"
#include "runtime/program/report/chart.h"
#include "runtime/program/report/table.h"
#include "runtime/program/reproduce/long_run.h"
#include "runtime/program/reproduce/thesis.h"
#include "runtime/split.h"

namespace tremolo::reproduce {
namespace {

using Json = nlohmann::json;

constexpr int kVersion = 1;                // of the long run and what it stores
constexpr double kLongTime = 10000.0;      // s
constexpr double kShortTime = 200.0;       // s
constexpr std::int64_t kSampleEvery = 10;  // steps of 3 ms: H costs an evaluation
constexpr std::int64_t kWindow = 1167;     // samples, 35.01 s
// The drift over millions of steps is a random walk of the solve's errors: its tolerance must lie
// below the criterion's 1e-9 by more than the root of the number of steps.
constexpr double kLongTolerance = 1e-12;
constexpr double kDriftBound = 1e-9;
constexpr double kHighBandBound = 0.005;

// part: of the step of 3 ms.
struct Member {
  std::string label;
  std::string integrator;
  int part = 1;
};

std::vector<Member> members() {
  std::vector<Member> list;
  if (has_method("ep4")) list = {{"ep4, half the step", "ep4", 2}, {"ep4", "ep4", 1}};
  list.push_back({"imexv", "imexv", 1});
  list.push_back({"imexv-thesis", "imexv-thesis", 1});
  list.push_back({"newmark", "newmark", 1});
  return list;
}

LongRunSpec spec_of(const SampleModel& horse, const Member& member, double duration) {
  LongRunSpec spec;
  spec.model = horse.model;
  spec.integrator = member.integrator;
  spec.step = thesis::kStep / member.part;
  spec.steps = member.part * static_cast<std::int64_t>(std::floor(duration / thesis::kStep));
  spec.sample_every = member.part * kSampleEvery;
  spec.window = kWindow;
  spec.tolerance = kLongTolerance;
  // The same band at every step.
  spec.low = static_cast<int>(choose_split(horse.model->lambda(), thesis::kStep, {})->low);
  return spec;
}

Result<LongRun> one_run(const Workshop& shop, const SampleModel& horse, const Member& member,
                        double duration) {
  const LongRunSpec spec = spec_of(horse, member, duration);
  const std::string name =
      fmt::format("long-{}-h{:g}ms-{:g}s", member.integrator, 1e3 * spec.step, duration);
  const Json key{{"program", shop.program}, {"model", horse.checksum},
                 {"version", kVersion},     {"name", name},
                 {"steps", spec.steps},     {"sample_every", spec.sample_every},
                 {"window", spec.window},   {"segment", spec.segment},
                 {"low", spec.low},         {"tolerance", spec.tolerance}};
  const std::string checkpoint =
      (std::filesystem::path(shop.directory) / (name + ".checkpoint")).string();
  Result<Json> json = shop.store.get(name, key, [&]() -> Result<Json> {
    Result<LongRun> run = run_to_end(spec, checkpoint, key, [&](const LongRun& now) {
      fmt::print(stderr, "tremolo: {}: {:.0f} of {:g} s\n", member.label,
                 static_cast<double>(now.done) * spec.step, duration);
    });
    if (!run) return run.error();
    return to_json(*run);
  });
  if (!json) return json.error();
  std::error_code ignored;
  std::filesystem::remove(checkpoint, ignored);
  return long_run_from_json(*json);
}

double change(const Windows& windows) {
  return mean(windows.last) / mean(windows.first) - 1.0;
}

std::string percent(double value) {
  return fmt::format("{:+.3g} %", 100.0 * value);
}

Table numbers_table(const std::vector<Member>& list, const std::vector<LongRun>& runs) {
  Table table{{"method", "reached, s", "total, first 35 s, J", "total, last 35 s, J", "change",
               "scatter of windows", "slope of H, 1/s", "its error, 1/s", "drift max|H-H0|/H0",
               "high band, first 35 s, J", "high band, last 35 s, J", "change of high band",
               "scatter of high-band windows"},
              {}};
  std::vector<std::string> theirs(table.columns.size());
  theirs[0] = "thesis, IMEXv";
  theirs[1] = "10000";
  theirs[4] = percent(thesis::kTotalChange);
  theirs[11] = percent(thesis::kHighBandChange);
  table.rows.push_back(std::move(theirs));
  for (std::size_t i = 0; i < list.size(); ++i) {
    const LongRun& run = runs[i];
    const double window = static_cast<double>(kWindow * kSampleEvery) * thesis::kStep;
    const Fit total = fit_line(run.total.means, window),
              high = fit_line(run.high_band.means, window);
    const bool whole = run.exit_code == 0;
    table.rows.push_back(
        {list[i].label,
         fmt::format("{:.6g}{}", static_cast<double>(run.done) * thesis::kStep / list[i].part,
                     whole ? "" : "*"),
         cell(mean(run.total.first), 6), cell(mean(run.total.last), 6),
         whole ? percent(change(run.total)) : "", cell(total.scatter / total.mean, 3),
         cell(total.slope / run.reference, 3), cell(total.slope_error / run.reference, 3),
         cell(run.drift, 3), cell(mean(run.high_band.first), 4), cell(mean(run.high_band.last), 4),
         whole ? percent(change(run.high_band)) : "", cell(high.scatter / high.mean, 3)});
  }
  return table;
}

std::vector<Criterion> criteria_of(const LongRun& run, const LongRun& control, double duration) {
  const double steps = duration / thesis::kStep;
  const double high = std::abs(change(run.high_band));
  const Fit windows = fit_line(run.high_band.means, 1.0);
  const double scatter = windows.scatter / mean(run.high_band.first);
  const double allowed = std::max(kHighBandBound, 2.0 * scatter);
  const bool whole = run.exit_code == 0;
  return {{fmt::format("experiment 3, ep4: relative energy drift over {:.3g} million steps",
                       1e-6 * steps),
           fmt::format("<= {:g}", kDriftBound), fmt::format("{:.2e}", run.drift),
           whole && run.drift <= kDriftBound},
          {"experiment 3, ep4: mean high-band energy of the last 35 s against the first",
           fmt::format("within 0.5 % or twice the scatter of windows ({:.3g} %)", 200.0 * scatter),
           fmt::format("{} (at half the step {})", percent(change(run.high_band)),
                       percent(change(control.high_band))),
           whole && high <= allowed}};
}

Series window_series(const std::vector<double>& values, double first_time) {
  Series series;
  for (std::size_t i = 0; i < values.size(); ++i)
    series.t.push_back(first_time +
                       static_cast<double>(i) * static_cast<double>(kSampleEvery) * thesis::kStep);
  series.y = values;
  thin(series.t, series.y, 240);
  return series;
}

Result<std::string> draw_figure17(const std::vector<Member>& list, const std::vector<LongRun>& runs,
                                  double duration, Table& csv) {
  std::vector<Chart> charts;
  const double window = static_cast<double>(kWindow * kSampleEvery) * thesis::kStep;
  for (const bool high : {false, true})
    for (const bool end : {false, true}) {
      Chart chart{
          fmt::format("{} energy, {} 35 s", high ? "high-band" : "total", end ? "last" : "first"),
          "t (s)", "energy (J)"};
      double top = 0.0;
      for (std::size_t i = 0; i < list.size(); ++i) {
        if (list[i].label != "imexv" && list[i].label != "ep4") continue;
        const Windows& windows = high ? runs[i].high_band : runs[i].total;
        for (const auto* values : {&windows.first, &windows.last})
          for (const double value : *values) top = std::max(top, value);
        const Series series =
            window_series(end ? windows.last : windows.first, end ? duration - window : 0.0);
        chart.curves.push_back({list[i].label, series.t, series.y,
                                list[i].label == "ep4" ? CurveStyle::kDashes : CurveStyle::kLines,
                                list[i].label == "ep4" ? "#333333" : "#0060a8"});
        for (std::size_t k = 0; k < series.t.size(); ++k)
          csv.rows.push_back(
              {chart.title, list[i].label, cell(series.t[k], 9), cell(series.y[k], 7)});
      }
      std::ranges::reverse(chart.curves);  // ep4 over it, thinly
      chart.y_range = {{0.0, 1.08 * top}};
      chart.x_range = end ? std::pair{duration - window, duration} : std::pair{0.0, window};
      charts.push_back(std::move(chart));
    }
  return draw_svg(charts, 2);
}

Result<std::string> draw_windows(const std::vector<Member>& list, const std::vector<LongRun>& runs,
                                 Table& csv) {
  std::vector<Chart> charts;
  const double window = static_cast<double>(kWindow * kSampleEvery) * thesis::kStep;
  for (const bool high : {false, true}) {
    Chart chart{high ? "high-band energy" : "total energy", "t (1000 s)",
                "mean over 35 s / mean over the first 35 s"};
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::vector<double>& means = high ? runs[i].high_band.means : runs[i].total.means;
      Curve curve{list[i].label, {}, {}};
      for (std::size_t k = 0; k < means.size(); ++k) {
        const double middle = (static_cast<double>(k) + 0.5) * window;
        curve.x.push_back(1e-3 * middle);
        curve.y.push_back(means[k] / means[0]);
        csv.rows.push_back({chart.title, list[i].label, cell(middle, 7), cell(means[k], 10)});
      }
      chart.curves.push_back(std::move(curve));
    }
    charts.push_back(std::move(chart));
  }
  return draw_svg(charts, 2);
}

}  // namespace

Result<std::vector<Criterion>> add_experiment3(Page& page, const Workshop& shop,
                                               const std::string& directory) {
  const auto horse = std::ranges::find(shop.models, "horse", &SampleModel::name);
  if (horse == shop.models.end()) return std::vector<Criterion>{};
  const double duration = shop.long_form ? kLongTime : kShortTime;
  const std::vector<Member> list = members();
  std::vector<std::optional<Result<LongRun>>> made(list.size());
  parallel_for(list.size(), shop.threads,
               [&](std::size_t i) { made[i] = one_run(shop, *horse, list[i], duration); });
  std::vector<LongRun> runs;
  for (auto& run : made) {
    if (!*run) return run->error();
    runs.push_back(std::move(**run));
  }

  page.section("Experiment 3: the energy over 10 000 s");
  page.paragraph(fmt::format(
      "The horse after one impulse, without damping, {:g} s, tolerance {:g} (the drift is the "
      "solver's error, so it must lie below the bound). H and the high band are evaluated every {} "
      "steps of 3 ms; a window is {} samples, 35.01 s. Changes, scatter and drift are relative; "
      "slope: of a line through the windows' means of H, over H0.{}",
      duration, kLongTolerance, kSampleEvery, kWindow,
      shop.long_form ? "" : " This is the short form; `--long` makes the 10 000 s of the thesis."));
  const Table numbers = numbers_table(list, runs);
  page.table(numbers, "Last 35 s against the first, and all windows of 35 s. * broke off.");
  page.paragraph(
      "What the thesis calls high-frequency energy is not defined there; ours is that of "
      "`runtime/energy.h`, in which the static part of the high coordinates does not count.");
  Table series{{"panel", "method", "t", "energy"}, {}}, windows{{"of", "method", "t", "mean"}, {}};
  Result<std::string> figure = draw_figure17(list, runs, duration, series);
  if (!figure) return figure.error();
  page.figure(*figure, fmt::format("Figure 17: horse, the first and the last 35 s of {:g} s, imexv "
                                   "and, over it, ep4.",
                                   duration));
  Result<std::string> means = draw_windows(list, runs, windows);
  if (!means) return means.error();
  page.figure(*means, "The means of all windows of 35 s. Not in the thesis.");
  const auto path = [&](const char* name) {
    return (std::filesystem::path(directory) / name).string();
  };
  if (Status status = write_csv(numbers, path("experiment-3.csv")); !status) return status.error();
  if (Status status = write_csv(series, path("figure-17.csv")); !status) return status.error();
  if (Status status = write_csv(windows, path("experiment-3-windows.csv")); !status)
    return status.error();
  if (list.front().integrator != "ep4") return std::vector<Criterion>{};
  return criteria_of(runs[1], runs[0], duration);
}

}  // namespace tremolo::reproduce
