#include "tests/lab/report/chart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include <fmt/format.h>

#include "runtime/program/output/gnuplot.h"
#include "tests/lab/report/svg.h"

namespace tremolo {
namespace {

// Dark enough for thin lines on white, apart for the colour-blind as far as twelve can be; the
// points' shapes help.
constexpr std::array kPalette = {"#0060a8", "#d95f02", "#1b9e77", "#7b3fa0", "#d01c6f", "#6b6b6b",
                                 "#8c5a1e", "#3aa6dd", "#000000", "#b2182b", "#6aa312", "#c99a00"};
constexpr std::array kPoints = {7, 5, 9, 11, 13, 6, 4, 8, 10, 12, 15, 14};

struct Look {
  std::string colour;
  int point = 7;
};

// The same label looks the same in all charts of a drawing.
class Looks {
 public:
  Look of(const Curve& curve) {
    auto known = std::find_if(known_.begin(), known_.end(), [&](const auto& entry) {
      return !curve.label.empty() && entry.first == curve.label;
    });
    if (known == known_.end()) {
      const std::size_t n = known_.size();
      known_.push_back(
          {curve.label,
           {kPalette[n % kPalette.size()], kPoints[(n + n / kPalette.size()) % kPoints.size()]}});
      known = known_.end() - 1;
    }
    Look look = known->second;
    if (!curve.colour.empty()) look.colour = curve.colour;
    return look;
  }

 private:
  std::vector<std::pair<std::string, Look>> known_;
};

std::string line_style(CurveStyle style) {
  if (style == CurveStyle::kPoints) return {};
  return style == CurveStyle::kDashes ? "lw 1.6 dt (8,5)" : "lw 1.6";
}

std::string point_style(CurveStyle style, int point) {
  const bool points = style == CurveStyle::kPoints || style == CurveStyle::kLinesAndPoints;
  return points ? fmt::format("pt {} ps 0.55", point) : std::string();
}

bool shown(double value, bool logarithmic) {
  return std::isfinite(value) && (!logarithmic || value > 0.0);
}

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  bool empty() const { return !(low <= high); }
  void take(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

struct Ranges {
  Range x, y;
};

Ranges data_ranges(const Chart& chart) {
  Ranges ranges;
  for (const Curve& curve : chart.curves)
    for (std::size_t i = 0; i < std::min(curve.x.size(), curve.y.size()); ++i)
      if (shown(curve.x[i], chart.log_x) && shown(curve.y[i], chart.log_y)) {
        ranges.x.take(curve.x[i]);
        ranges.y.take(curve.y[i]);
      }
  return ranges;
}

// 1, 2 or 5 times a power of ten: four to nine of them fit into `width`.
double round_step(double width) {
  const double decade = std::pow(10.0, std::floor(std::log10(width)));
  const double lead = width / decade;
  return decade * (lead < 2.0 ? 0.2 : lead < 4.0 ? 0.5 : lead < 8.0 ? 1.0 : 2.0);
}

// gnuplot labels whole decades only, which leaves short ranges without a number.
std::string log_tics(char axis, Range range) {
  const double decades = std::log10(range.high / range.low);
  if (decades >= 2.0) {
    const bool plain = range.low >= 1e-3 && range.high <= 1e5;
    return fmt::format("set format {} '{}'\n", axis, plain ? "%g" : "10^{%L}");
  }
  std::string list;
  const auto add = [&](double value, bool label) {
    list += fmt::format("{}'{}' {:.17g} {}", list.empty() ? "" : ",",
                        label ? fmt::format("{:.6g}", value) : "", value, label ? 0 : 1);
  };
  if (decades < 0.5) {
    const double step = round_step(range.high - range.low);
    for (double k = std::ceil(range.low / step); k * step <= range.high; ++k) add(k * step, true);
    return fmt::format("set {}tics ({})\n", axis, list);
  }
  for (int decade = static_cast<int>(std::floor(std::log10(range.low)));
       decade <= static_cast<int>(std::ceil(std::log10(range.high))); ++decade)
    for (int digit = 1; digit < 10; ++digit)
      add(digit * std::pow(10.0, decade), digit == 1 || digit == 2 || digit == 5);
  return fmt::format("set {}tics ({})\n", axis, list);
}

// As many as have room on a small chart.
std::string linear_tics(char axis, Range range) {
  const double step = round_step(range.high - range.low);
  const double largest = std::max(std::abs(range.low), std::abs(range.high));
  const char* format = step < 1e-5 * largest ? "%.10g"
                       : step >= 1e4         ? "%.0s%c"  // 200k
                                             : "%.6g";
  return fmt::format("set {0}tics {1:.17g}\nset format {0} '{2}'\n", axis, step, format);
}

std::string axis_script(char axis, const std::string& label, bool logarithmic, Range range,
                        const std::optional<std::pair<double, double>>& wanted) {
  std::string text = fmt::format("set {}label {} noenhanced\n", axis, gnuplot_quoted(label));
  if (range.empty()) range = {0.0, 1.0}, logarithmic = false;
  bool fixed = false;
  if (wanted && (!logarithmic || wanted->first > 0.0))
    range = {wanted->first, wanted->second}, fixed = true;
  if (!(range.high > range.low)) {  // gnuplot would warn
    const double half = range.low == 0.0 ? 1.0 : 0.5 * std::abs(range.low);
    range = logarithmic ? Range{range.low / 2.0, range.low * 2.0}
                        : Range{range.low - half, range.high + half};
    fixed = true;
  }
  if (logarithmic) {
    if (!fixed) {  // a little room: points on the frame are hard to read
      const double room = std::pow(range.high / range.low, 0.04);
      range = {range.low / room, range.high * room};
    }
    text += fmt::format("set logscale {}\n", axis) + log_tics(axis, range);
  } else {
    text += linear_tics(axis, range);
  }
  if (logarithmic || fixed)
    text += fmt::format("set {}range [{:.17g}:{:.17g}]\n", axis, range.low, range.high);
  return text;
}

// Blank lines are gaps; two of them would begin another data set.
std::string data_block(const std::string& name, const Curve& curve, const Chart& chart) {
  std::string text = name + " << END_OF_DATA\n";
  bool gap = true;
  for (std::size_t i = 0; i < std::min(curve.x.size(), curve.y.size()); ++i) {
    if (shown(curve.x[i], chart.log_x) && shown(curve.y[i], chart.log_y)) {
      text += fmt::format("{:.9g} {:.9g}\n", curve.x[i], curve.y[i]);
      gap = false;
    } else if (!gap) {
      text += "\n";
      gap = true;
    }
  }
  return text + "END_OF_DATA\n";
}

bool has_data(const Curve& curve, const Chart& chart) {
  for (std::size_t i = 0; i < std::min(curve.x.size(), curve.y.size()); ++i)
    if (shown(curve.x[i], chart.log_x) && shown(curve.y[i], chart.log_y)) return true;
  return false;
}

std::string chart_script(const Chart& chart, const std::string& place, Looks& looks) {
  std::string text = "reset\n" + place +
                     "set border 3 lc rgb '#555555'\nset tics nomirror scale 0.6 textcolor rgb "
                     "'#333333'\nset grid lc rgb '#e3e6e9' lw 1\nunset key\n";
  text += fmt::format("set title {} noenhanced\n", gnuplot_quoted(chart.title));
  const Ranges ranges = data_ranges(chart);
  text += axis_script('x', chart.x_label, chart.log_x, ranges.x, chart.x_range);
  text += axis_script('y', chart.y_label, chart.log_y, ranges.y, chart.y_range);
  std::string plot;
  for (std::size_t i = 0; i < chart.curves.size(); ++i) {
    const Curve& curve = chart.curves[i];
    const Look look = looks.of(curve);  // also for one without data: the others keep their looks
    if (!has_data(curve, chart)) continue;
    const std::string name = fmt::format("$curve{}", i);
    text += data_block(name, curve, chart);
    const std::string line = line_style(curve.style), point = point_style(curve.style, look.point);
    const char* with = line.empty() ? "points" : point.empty() ? "lines" : "linespoints";
    plot += fmt::format("{}{} using 1:2 with {} {} {} lc rgb '{}' title {} noenhanced",
                        plot.empty() ? "plot " : ", ", name, with, line, point, look.colour,
                        gnuplot_quoted(curve.label));
  }
  if (plot.empty())
    return text +
           "set label 'no data' at graph 0.5,0.5 center textcolor rgb '#777777'\n"
           "plot [0:1][0:1] -1 notitle\n";
  return text + plot + "\n";
}

std::vector<LegendEntry> legend_of(const std::vector<Chart>& charts) {
  Looks looks;
  std::vector<LegendEntry> legend;
  for (const Chart& chart : charts)
    for (const Curve& curve : chart.curves) {
      const Look look = looks.of(curve);
      if (curve.label.empty()) continue;
      LegendEntry entry{curve.label, look.colour, line_style(curve.style),
                        point_style(curve.style, look.point)};
      const bool known = std::any_of(legend.begin(), legend.end(), [&](const LegendEntry& other) {
        return other.label == entry.label && other.colour == entry.colour &&
               other.line == entry.line && other.point == entry.point;
      });
      if (!known) legend.push_back(std::move(entry));
    }
  return legend;
}

}  // namespace

Result<std::string> draw_svg(const std::vector<Chart>& charts, int columns, int width, int height) {
  const Sheet sheet(static_cast<int>(charts.size()), columns, width, height, legend_of(charts));
  Looks looks;
  std::string plots;
  for (std::size_t i = 0; i < charts.size(); ++i)
    plots += chart_script(charts[i], sheet.panel(static_cast<int>(i)), looks);
  return sheet.draw(plots);
}

void thin(std::vector<double>& x, std::vector<double>& y, std::size_t buckets) {
  const std::size_t size = std::min(x.size(), y.size());
  if (buckets == 0 || size <= 4 * buckets) return;
  std::vector<double> kept_x, kept_y;
  for (std::size_t b = 0; b < buckets; ++b) {
    const std::size_t begin = b * size / buckets, end = (b + 1) * size / buckets;
    std::array<std::size_t, 4> keep = {begin, begin, begin, end - 1};
    for (std::size_t i = begin; i < end; ++i) {
      // A value that is not a number is lower and higher than none, unless nothing else is there.
      if (y[i] < y[keep[1]] || std::isnan(y[keep[1]])) keep[1] = i;
      if (y[i] > y[keep[2]] || std::isnan(y[keep[2]])) keep[2] = i;
    }
    std::sort(keep.begin(), keep.end());
    for (auto i = keep.begin(); i != std::unique(keep.begin(), keep.end()); ++i) {
      kept_x.push_back(x[*i]);
      kept_y.push_back(y[*i]);
    }
  }
  x = std::move(kept_x);
  y = std::move(kept_y);
}

}  // namespace tremolo
