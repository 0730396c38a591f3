#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <limits>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/file/atomic_file.h"
#include "formats/file/input_file.h"
#include "formats/file/scanner.h"
#include "runtime/apps/tremolo/output/chart.h"
#include "runtime/apps/tremolo/output/plot.h"
#include "runtime/apps/tremolo/output/text_values.h"
#include "runtime/io/page/document.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;
using OrderedJson = nlohmann::ordered_json;

constexpr std::size_t kBuckets = 2500;  // of a curve: enough for a wide screen with some zoom

Result<double> cell_value(std::string_view cell, const std::string& where) {
  if (cell.empty()) return std::numeric_limits<double>::quiet_NaN();
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size())
    return content_error(where + ": expected a number, found " + quoted_text(std::string(cell)));
  return value;
}

// Positions of the columns t, total and high_band in a line of names; -1: absent.
Result<std::array<std::ptrdiff_t, 3>> energy_columns(std::string_view header,
                                                     const std::string& csv) {
  const std::vector<std::string_view> names = cells_of(header);
  std::array<std::ptrdiff_t, 3> columns = {-1, -1, -1};
  constexpr std::array<std::string_view, 3> kNames = {"t", "total", "high_band"};
  for (std::size_t k = 0; k < kNames.size(); ++k) {
    const auto found = std::find(names.begin(), names.end(), kNames[k]);
    if (found != names.end()) columns[k] = found - names.begin();
    if (k < 2 && columns[k] < 0)
      return content_error(fmt::format("{}, line 1: expected a column `{}`, found {}", csv,
                                       kNames[k], quoted_text(std::string(header))));
  }
  return columns;
}

Chart energy_chart(const std::string& title, bool of_film) {
  Chart chart;
  chart.title = title;
  chart.x_label = "time (s)";
  chart.y_label = "J";
  chart.zero = true;
  chart.time = of_film;
  return chart;
}

Curve energy_curve(const std::string& label, std::vector<double> x, std::vector<double> y) {
  thin(x, y, kBuckets);
  return {.label = label, .x = std::move(x), .y = std::move(y)};
}

}  // namespace

std::vector<PlotSource> plot_sources(const std::vector<std::string>& runs) {
  std::vector<PlotSource> sources;
  for (const std::string& run : runs) {
    const fs::path path(run);
    const fs::path csv = fs::is_directory(path) ? path / "run.csv" : path;
    const fs::path folder = (fs::is_directory(path) ? path : path.parent_path()) / "";
    sources.push_back({folder.parent_path().filename().string(), csv.string()});
  }
  return sources;
}

Result<EnergyTable> read_energies(const std::string& csv) {
  const Result<std::string> whole = read_whole_file(csv);
  if (!whole) return whole.error();
  EnergyTable table;
  std::array<std::ptrdiff_t, 3> columns{};
  std::size_t number = 0;
  for (std::size_t at = 0; at < whole->size() || number == 0;) {
    const std::size_t end = std::min(whole->find('\n', at), whole->size());
    const std::string_view line = without_return(std::string_view(*whole).substr(at, end - at));
    at = end + 1;
    if (++number == 1) {
      if (Status s = take(columns, energy_columns(line, csv)); !s) return s.error();
      continue;
    }
    const std::vector<std::string_view> cells = cells_of(line);
    for (std::size_t k = 0; k < columns.size(); ++k) {
      if (columns[k] < 0) continue;
      const std::string where = fmt::format("{}, line {}", csv, number);
      if (!std::cmp_less(columns[k], cells.size()))
        return content_error(where + ": the line is too short");
      const Result<double> value = cell_value(cells[columns[k]], where);
      if (!value) return value.error();
      (k == 0 ? table.t : k == 1 ? table.total : table.high_band).push_back(*value);
    }
  }
  return table;
}

Result<OrderedJson> energy_charts(const std::vector<PlotSource>& sources, bool of_film) {
  Chart total = energy_chart("total energy", of_film);
  Chart high_band = energy_chart("energy of the high band", of_film);
  for (const PlotSource& source : sources) {
    const Result<EnergyTable> table = read_energies(source.csv);
    if (!table) return table.error();
    total.curves.push_back(energy_curve(source.label, table->t, table->total));
    if (!table->high_band.empty())
      high_band.curves.push_back(energy_curve(source.label, table->t, table->high_band));
  }
  OrderedJson charts = OrderedJson::array({to_json(total)});
  if (!high_band.curves.empty()) charts.push_back(to_json(high_band));
  return OrderedJson{{"caption", ""},
                     {"columns", 1},
                     {"height", 320},
                     {"linked", true},
                     {"charts", std::move(charts)}};
}

Status write_energy_page(const std::vector<PlotSource>& sources, const std::string& output) {
  Result<OrderedJson> charts = energy_charts(sources, false);
  if (!charts) return charts.error();
  std::vector<std::string> labels;
  for (const PlotSource& source : sources) labels.push_back(source.label);
  const OrderedJson part = {{"kind", "charts"}, {"charts", std::move(*charts)}};
  const OrderedJson section = {{"title", ""}, {"parts", OrderedJson::array({part})}};
  const OrderedJson report = {{"title", "Energy"},
                              {"subtitle", fmt::format("{}", fmt::join(labels, ", "))},
                              {"sections", OrderedJson::array({section})}};
  return write_file(
      output, page_document(report.dump(-1, ' ', false, OrderedJson::error_handler_t::replace)));
}

}  // namespace tremolo
