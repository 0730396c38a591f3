#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "runtime/program/output/gnuplot.h"
#include "tests/lab/report/chart.h"
#include "tests/lab/report/svg.h"

namespace tremolo {
namespace {

constexpr int kCellWidth = 58;   // px
constexpr int kCellHeight = 26;  // px
constexpr int kLetter = 8;       // px
constexpr int kRight = 20;       // px
constexpr int kAbove = 52;       // px, the title
constexpr int kBelow = 60;       // px, column names and label

std::size_t longest(const std::vector<std::string>& texts) {
  std::size_t length = 0;
  for (const std::string& text : texts) length = std::max(length, text.size());
  return length;
}

int left_of(const CellChart& chart) {
  return kLetter * static_cast<int>(longest(chart.rows)) + (chart.y_label.empty() ? 16 : 40);
}

// "#rrggbb": text on it is white where it is dark.
bool is_dark(std::string_view colour) {
  if (colour.size() != 7) return false;
  const auto part = [&](std::size_t at) {
    return static_cast<double>(std::stoi(std::string(colour.substr(at, 2)), nullptr, 16));
  };
  return 0.299 * part(1) + 0.587 * part(3) + 0.114 * part(5) < 140.0;
}

std::string names(char axis, const std::vector<std::string>& texts) {
  std::string list;
  for (std::size_t i = 0; i < texts.size(); ++i)
    list += fmt::format("{}{} {}", i == 0 ? "" : ",", gnuplot_quoted(texts[i]), i);
  return fmt::format("set {}tics ({}) noenhanced\n", axis, list);
}

std::string cells(const CellChart& chart) {
  std::string text;
  int object = 0;
  for (std::size_t r = 0; r < chart.values.size(); ++r)
    for (std::size_t c = 0; c < chart.values[r].size(); ++c) {
      const int value = chart.values[r][c];
      if (value < 0 || value >= static_cast<int>(chart.classes.size())) continue;
      const std::string& colour = chart.classes[static_cast<std::size_t>(value)].second;
      const double x = static_cast<double>(c), y = static_cast<double>(r);
      text += fmt::format(
          "set object {} rectangle from {},{} to {},{} fc rgb '{}' fillstyle solid 1 border lc rgb "
          "'#ffffff'\n",
          ++object, x - 0.5, y - 0.5, x + 0.5, y + 0.5, colour);
      if (r < chart.marks.size() && c < chart.marks[r].size() && !chart.marks[r][c].empty())
        text += fmt::format(
            "set label {} at {},{} center front noenhanced font ',11' textcolor rgb '{}'\n",
            gnuplot_quoted(chart.marks[r][c]), x, y, is_dark(colour) ? "#ffffff" : "#111111");
    }
  return text;
}

std::string chart_script(const CellChart& chart, const std::string& place) {
  const std::size_t columns = std::max<std::size_t>(chart.columns.size(), 1);
  const std::size_t rows = std::max<std::size_t>(chart.rows.size(), 1);
  std::string text = "reset\n" + place;
  text += fmt::format(
      "unset key\nunset border\nset tics scale 0 textcolor rgb '#333333'\nset title {} noenhanced\n"
      "set xlabel {} noenhanced\nset ylabel {} noenhanced\n",
      gnuplot_quoted(chart.title), gnuplot_quoted(chart.x_label), gnuplot_quoted(chart.y_label));
  text += names('x', chart.columns) + names('y', chart.rows) + cells(chart);
  return text + fmt::format("plot [-0.5:{}][{}:-0.5] -2 notitle\n",
                            static_cast<double>(columns) - 0.5, static_cast<double>(rows) - 0.5);
}

}  // namespace

Result<std::string> draw_svg(const std::vector<CellChart>& charts, int columns) {
  int width = 120, height = 80, left = 0;
  std::vector<LegendEntry> legend;
  for (const CellChart& chart : charts) {
    const int count = static_cast<int>(std::max<std::size_t>(chart.columns.size(), 1));
    const int letters = static_cast<int>(std::max(longest(chart.columns), std::size_t{1}));
    left = std::max(left, left_of(chart));
    width = std::max(width, left + count * std::max(kCellWidth, kLetter * letters) + kRight);
    height = std::max(height, kAbove + kBelow + kCellHeight * static_cast<int>(chart.rows.size()));
  }
  if (!charts.empty())
    for (const auto& [label, colour] : charts.front().classes)
      legend.push_back({label, colour, "", "pt 5 ps 1.4"});
  const Sheet sheet(static_cast<int>(charts.size()), columns, width, height, std::move(legend));
  std::string plots;
  for (std::size_t i = 0; i < charts.size(); ++i)
    plots +=
        chart_script(charts[i], sheet.panel(static_cast<int>(i), left, kRight, kAbove, kBelow));
  return sheet.draw(plots);
}

Result<std::string> draw_svg(const CellChart& chart) {
  return draw_svg(std::vector<CellChart>{chart}, 1);
}

}  // namespace tremolo
