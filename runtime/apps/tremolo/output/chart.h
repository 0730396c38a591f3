// Charts as data; runtime/io/page/charts.js draws them.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace tremolo {

enum class CurveStyle { kLines, kLinesAndPoints, kPoints, kDashes };

// x, y: of equal length; a pair with a value that is not finite leaves a gap, and on a logarithmic
// axis so does one that is not positive. colour: "#rrggbb"; empty: that of the method which is the
// label, or the next of the palette, the same for the same label in all charts of one figure.
struct Curve {
  std::string label = {};  // empty: not in the legend
  std::vector<double> x = {};
  std::vector<double> y = {};
  CurveStyle style = CurveStyle::kLines;
  std::string colour = {};
  std::vector<int> loops = {};  // of each pair: the loop of the page's film it plays; or empty
};

// zero: the y axis begins there unless values are below. time: x is the time of a film on the same
// page, s.
struct Chart {
  std::string title = {};
  std::string x_label = {};
  std::string y_label = {};
  bool log_x = false;
  bool log_y = false;
  bool zero = false;
  bool time = false;
  std::optional<std::pair<double, double>> x_range = {};
  std::optional<std::pair<double, double>> y_range = {};
  std::vector<Curve> curves = {};
};

// A grid of coloured cells, row 0 at the top: values[row][column] is an index into `classes`, -1
// leaves a cell empty. All rows are as long as `columns`.
struct CellChart {
  std::string title = {};
  std::string x_label = {};
  std::string y_label = {};
  std::vector<std::string> columns = {};
  std::vector<std::string> rows = {};
  std::vector<std::vector<int>> values = {};
  std::vector<std::vector<std::string>> marks = {};  // a short text in each cell, or none
  std::vector<std::pair<std::string, std::string>> classes = {};  // label, colour
};

// As report.json holds them. Coordinates have nine significant digits; both coordinates of a pair
// that leaves a gap are null.
nlohmann::ordered_json to_json(const Chart& chart);
nlohmann::ordered_json to_json(const CellChart& chart);

// Thins a long series to what a chart of `buckets` columns can show: of each bucket the first,
// lowest, highest and last point, in order.
void thin(std::vector<double>& x, std::vector<double>& y, std::size_t buckets);

}  // namespace tremolo
