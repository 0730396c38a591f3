#include "precompute/sensitivity/measurements.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/text.h"
#include "formats/file/input_file.h"
#include "formats/file/scanner.h"

namespace tremolo {
namespace {

enum Column { kMode, kFrequency, kFrequencySd, kRatio, kRatioSd, kDecay, kDecaySd, kColumns };
constexpr std::array<std::string_view, kColumns> kColumnNames = {
    "mode",       "frequency",    "frequency_sd", "damping_ratio", "damping_ratio_sd",
    "decay_time", "decay_time_sd"};
constexpr double kEmpty = std::numeric_limits<double>::quiet_NaN();

using Cells = std::array<double, kColumns>;

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t at = 0; at <= line.size();) {
    const std::size_t end = std::min(line.find(',', at), line.size());
    cells.push_back(trimmed(line.substr(at, end - at)));
    at = end + 1;
  }
  return cells;
}

Result<std::vector<Column>> read_header(std::string_view line) {
  std::vector<Column> columns;
  for (const std::string_view name : cells_of(line)) {
    const auto known = std::find(kColumnNames.begin(), kColumnNames.end(), name);
    if (known == kColumnNames.end())
      return content_error("there is no column '" + std::string(name) +
                           "': a first line names the columns, of mode, frequency, frequency_sd, "
                           "damping_ratio, damping_ratio_sd, decay_time, decay_time_sd");
    const auto column = static_cast<Column>(known - kColumnNames.begin());
    if (std::find(columns.begin(), columns.end(), column) != columns.end())
      return content_error("the column '" + std::string(name) + "' is there twice");
    columns.push_back(column);
  }
  const auto has = [&columns](Column column) {
    return std::find(columns.begin(), columns.end(), column) != columns.end();
  };
  if (!has(kMode) && !has(kFrequency))
    return content_error("a column `frequency` or `mode` is needed");
  return columns;
}

bool read_number(std::string_view cell, bool ratio, double& value) {
  const bool percent = ratio && cell.ends_with('%');
  if (percent) cell.remove_suffix(1);
  const auto [stop, error] = read_decimal(cell.data(), cell.data() + cell.size(), value);
  if (percent) value *= 0.01;
  return error == std::errc{} && stop == cell.data() + cell.size() && std::isfinite(value);
}

Status read_cells(const std::vector<Column>& columns, std::string_view line, Cells& cells) {
  cells.fill(kEmpty);
  const std::vector<std::string_view> texts = cells_of(line);
  if (texts.size() != columns.size())
    return content_error("it has " + std::to_string(texts.size()) + " cells, the first line has " +
                         std::to_string(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (texts[i].empty()) continue;
    const Column column = columns[i];
    double value = 0.0;
    if (!read_number(texts[i], column == kRatio || column == kRatioSd, value))
      return content_error(std::string(kColumnNames[column]) + ": '" + std::string(texts[i]) +
                           "' is not a number");
    const bool can_be_zero = column == kRatio;
    if (!(value > 0.0) && !(can_be_zero && value == 0.0))
      return content_error(std::string(kColumnNames[column]) + " must be positive");
    cells[column] = value;
  }
  return Success{};
}

// The ratio of a row that has one; its frequency is then known.
Result<Uncertain> ratio_of_cells(const Cells& cells) {
  const auto known = [&cells](Column column) { return !std::isnan(cells[column]); };
  if (known(kRatio) && known(kDecay))
    return content_error("give damping_ratio or decay_time, not both");
  Uncertain ratio;
  if (known(kRatio)) {
    if (!(cells[kRatio] < 1.0))
      return content_error("damping_ratio is a fraction of critical damping, below 1");
    ratio = {cells[kRatio], known(kRatioSd) ? cells[kRatioSd] : 0.0};
  } else {
    if (!known(kFrequency)) return content_error("decay_time needs the frequency");
    const double period = 1.0 / cells[kFrequency];
    if (cells[kDecay] < period)
      return content_error(
          "a decay_time of " + number_text(cells[kDecay]) + " s is shorter than the period of " +
          number_text(cells[kFrequency]) + " Hz, " + text("%.3g", period) +
          " s: nothing rings so. It is in seconds, not ms; heavier damping is given as "
          "damping_ratio");
    // e^{-zeta omega t} with the frequency omega sqrt(1 - zeta^2) of the zeros.
    const double rate = 1.0 / cells[kDecay];
    const double omega = std::hypot(2.0 * std::numbers::pi * cells[kFrequency], rate);
    ratio.value = rate / omega;
    // The frequency's deviation hardly matters beside that of a decay.
    const double share = (1.0 - ratio.value * ratio.value) / cells[kDecay];
    ratio.deviation = known(kDecaySd) ? ratio.value * share * cells[kDecaySd] : 0.0;
  }
  return ratio;
}

Result<MeasuredMode> row_of(const Cells& cells, int line) {
  const auto known = [&cells](Column column) { return !std::isnan(cells[column]); };
  MeasuredMode row;
  row.line = line;
  if (known(kMode)) {
    if (cells[kMode] != std::floor(cells[kMode]) || cells[kMode] > 1e6)
      return content_error("mode must be 1, 2, ...");
    row.mode = static_cast<int>(cells[kMode]) - 1;
  }
  if (!known(kFrequency) && !row.mode)
    return content_error("it has neither a frequency nor a mode");
  if (known(kRatio) || known(kDecay)) {
    const Result<Uncertain> ratio = ratio_of_cells(cells);
    if (!ratio) return ratio.error();
    row.ratio = *ratio;
    if (known(kDecay))
      row.decay = Uncertain{cells[kDecay], known(kDecaySd) ? cells[kDecaySd] : 0.0};
  }
  if (!known(kFrequency)) {
    if (!row.ratio) return content_error("it has a mode, but neither a frequency nor damping");
    return row;
  }
  const double zeta = row.ratio ? row.ratio->value : 0.0;
  row.stretch = 1.0 / std::sqrt(1.0 - zeta * zeta);
  row.frequency = Uncertain{row.stretch * cells[kFrequency],
                            known(kFrequencySd) ? row.stretch * cells[kFrequencySd] : 0.0};
  return row;
}

// True if all have a deviation, false if none has; else an error. `which`: the member.
Result<bool> all_or_none(const std::vector<MeasuredMode>& rows,
                         std::optional<Uncertain> MeasuredMode::*which, const char* name) {
  std::size_t with = 0, all = 0;
  for (const MeasuredMode& row : rows) {
    if (!(row.*which)) continue;
    ++all;
    if ((row.*which)->deviation > 0.0) ++with;
  }
  if (with != 0 && with != all)
    return content_error(std::string("some rows have the standard deviation of ") + name +
                         ", others have not: give all or none");
  return all > 0 && with == all;
}

Status check_rows(const std::vector<MeasuredMode>& rows, const std::string& path) {
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const std::string where = path + ", line " + std::to_string(rows[i].line) + ": ";
      if (rows[i].mode && rows[j].mode == rows[i].mode)
        return content_error(where + "mode " + std::to_string(*rows[i].mode + 1) +
                             " is there twice");
      if (rows[i].frequency && rows[j].frequency && !rows[i].mode && !rows[j].mode &&
          rows[i].frequency->value == rows[j].frequency->value)
        return content_error(where + "this frequency is there twice: name the modes");
    }
  return Success{};
}

}  // namespace

Result<Measurements> parse_measurements(std::string_view text, const std::string& path) {
  text = without_mark(text);
  Measurements measured;
  std::vector<Column> columns;
  int line = 0;
  const auto at_line = [&](const Error& error) {
    return content_error(path + ", line " + std::to_string(line) + ": " + error.message);
  };
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string_view content = text.substr(at, end - at);
    at = end + 1;
    ++line;
    content = trimmed(content.substr(0, content.find('#')));
    if (content.empty()) continue;
    if (columns.empty()) {
      Result<std::vector<Column>> header = read_header(content);
      if (!header) return at_line(header.error());
      columns = std::move(*header);
      continue;
    }
    Cells cells;
    if (Status s = read_cells(columns, content, cells); !s) return at_line(s.error());
    Result<MeasuredMode> row = row_of(cells, line);
    if (!row) return at_line(row.error());
    measured.rows.push_back(*row);
  }
  if (measured.rows.empty()) return content_error(path + ": no measurement is in it");
  if (Status s = check_rows(measured.rows, path); !s) return s.error();
  const auto in_file = [&path](const Error& error) {
    return content_error(path + ": " + error.message);
  };
  const Result<bool> of_frequency =
      all_or_none(measured.rows, &MeasuredMode::frequency, "the frequency");
  if (!of_frequency) return in_file(of_frequency.error());
  const Result<bool> of_ratio = all_or_none(measured.rows, &MeasuredMode::ratio, "the damping");
  if (!of_ratio) return in_file(of_ratio.error());
  measured.frequency_deviations = *of_frequency;
  measured.ratio_deviations = *of_ratio;
  return measured;
}

Result<Measurements> read_measurements(const std::string& path) {
  const Result<std::string> text = read_whole_file(path);
  if (!text) return text.error();
  return parse_measurements(*text, path);
}

}  // namespace tremolo
