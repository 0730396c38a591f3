#include "tests/lab/reproduce/experiment3_parts.h"

#include <algorithm>

#include <fmt/format.h>

#include "tests/lab/reproduce/orbit.h"

namespace tremolo::reproduce {
namespace {

double sample_spacing(const LabelledRun& one) {
  return static_cast<double>(one.spec.sample_every) * one.spec.step;
}

Series window_series(const LabelledRun& one, const std::vector<double>& values, double begin) {
  Series series;
  for (std::size_t i = 0; i < values.size(); ++i)
    series.t.push_back(begin + static_cast<double>(i) * sample_spacing(one));
  series.y = values;
  thin(series.t, series.y, 240);
  return series;
}

std::string whole_change(const LabelledRun& one, const Windows& windows) {
  return one.run.finished() ? percent(change(windows)) : std::string();
}

}  // namespace

double LabelledRun::reached() const {
  return static_cast<double>(run.done) * spec.step;
}

double LabelledRun::window_length() const {
  return static_cast<double>(spec.window * spec.sample_every) * spec.step;
}

double change(const Windows& windows) {
  return mean(windows.last) / mean(windows.first) - 1.0;
}

Fit high_band_trend(const LabelledRun& one) {
  return fit_line(one.run.high_band.means, one.window_length());
}

std::string percent(double value) {
  return fmt::format("{:+.3g} %", 100.0 * value);
}

Table total_energy_table(const std::vector<LabelledRun>& runs, const thesis::Thesis& thesis) {
  Table table{{"method", "tolerance", "reached, s", "first 35 s, J", "last 35 s, J", "change",
               "scatter of windows", "slope of H, 1/s", "its error, 1/s", "drift max|H-H0|/H0"},
              {}};
  table.rows.push_back(
      {"thesis, IMEXv", "", "10000", "", "", percent(thesis.total_change), "", "", "", ""});
  for (const LabelledRun& one : runs) {
    const Fit fit = fit_line(one.run.total.means, one.window_length());
    table.rows.push_back({one.label, fmt::format("{:g}", one.spec.tolerance),
                          fmt::format("{:.6g}{}", one.reached(), one.run.finished() ? "" : "*"),
                          cell(mean(one.run.total.first), 6), cell(mean(one.run.total.last), 6),
                          whole_change(one, one.run.total), cell(fit.scatter / fit.mean, 3),
                          cell(fit.slope / one.run.reference, 3),
                          cell(fit.slope_error / one.run.reference, 3), cell(one.run.drift, 3)});
  }
  return table;
}

Table high_band_table(const std::vector<LabelledRun>& runs, const thesis::Thesis& thesis) {
  Table table{
      {"method", "tolerance", "first 35 s, J", "last 35 s, J", "change", "scatter of windows",
       "trend over the run", "of the scatter, on a line", "iterations a step"},
      {}};
  table.rows.push_back(
      {"thesis, IMEXv", "", "", "", percent(thesis.high_band_change), "", "", "", ""});
  for (const LabelledRun& one : runs) {
    const Fit fit = high_band_trend(one);
    table.rows.push_back(
        {one.label, fmt::format("{:g}", one.spec.tolerance), cell(mean(one.run.high_band.first), 6),
         cell(mean(one.run.high_band.last), 6), whole_change(one, one.run.high_band),
         cell(fit.scatter / fit.mean, 3), percent(fit.slope * one.reached() / fit.mean),
         fmt::format("{:.0f} %", 100.0 * fit.explained),
         cell(static_cast<double>(one.run.iterations) / static_cast<double>(one.run.done), 3)});
  }
  return table;
}

std::vector<Chart> figure17_charts(const std::vector<LabelledRun>& runs, Table& csv) {
  std::vector<Chart> charts;
  for (const bool high : {false, true})
    for (const bool end : {false, true}) {
      Chart chart{
          fmt::format("{} energy, {} 35 s", high ? "high-band" : "total", end ? "last" : "first"),
          "t (s)", "energy (J)"};
      double top = 0.0;
      for (const LabelledRun& one : runs) {
        if (one.label != "imexv" && one.label != "ep4") continue;
        const Windows& windows = high ? one.run.high_band : one.run.total;
        for (const auto* values : {&windows.first, &windows.last})
          for (const double value : *values) top = std::max(top, value);
        const double begin = end ? one.reached() - one.window_length() : 0.0;
        const Series series = window_series(one, end ? windows.last : windows.first, begin);
        const bool ours = one.label == "ep4";
        chart.curves.push_back({one.label, series.t, series.y,
                                ours ? CurveStyle::kDashes : CurveStyle::kLines,
                                ours ? "#333333" : "#0060a8"});
        chart.x_range = {{begin, begin + one.window_length()}};
        for (std::size_t k = 0; k < series.t.size(); ++k)
          csv.rows.push_back({chart.title, one.label, cell(series.t[k], 9), cell(series.y[k], 7)});
      }
      std::ranges::reverse(chart.curves);  // ep4 over it, thinly
      chart.y_range = {{0.0, 1.08 * top}};
      charts.push_back(std::move(chart));
    }
  return charts;
}

std::vector<Chart> windows_charts(const std::vector<LabelledRun>& runs, Table& csv) {
  std::vector<Chart> charts;
  for (const bool high : {false, true}) {
    Chart chart{high ? "high-band energy" : "total energy", "t (1000 s)",
                "mean over 35 s / mean over the first 35 s"};
    for (const LabelledRun& one : runs) {
      const std::vector<double>& means = high ? one.run.high_band.means : one.run.total.means;
      Curve curve{one.label, {}, {}};
      for (std::size_t k = 0; k < means.size(); ++k) {
        const double middle = (static_cast<double>(k) + 0.5) * one.window_length();
        curve.x.push_back(1e-3 * middle);
        curve.y.push_back(means[k] / means[0]);
        csv.rows.push_back({chart.title, one.label, cell(middle, 7), cell(means[k], 10)});
      }
      chart.curves.push_back(std::move(curve));
    }
    charts.push_back(std::move(chart));
  }
  return charts;
}

}  // namespace tremolo::reproduce
