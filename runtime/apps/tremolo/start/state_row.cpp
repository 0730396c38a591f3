#include <algorithm>
#include <charconv>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "runtime/apps/tremolo/output/text_values.h"
#include "runtime/apps/tremolo/start/start_state.h"

namespace tremolo {
namespace {

bool to_number(std::string_view cell, double& value) {
  const auto [stop, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return error == std::errc{} && stop == cell.data() + cell.size() && std::isfinite(value);
}

// Positions of t, q0 ... and p0 ... in a row.
struct Columns {
  std::size_t time = 0;
  std::vector<std::size_t> q, p;
};

Result<Columns> find_columns(std::string_view head, Eigen::Index modes, const std::string& path) {
  const std::vector<std::string_view> names = cells_of(head);
  const auto find = [&](const std::string& name) -> std::size_t {
    return std::find(names.begin(), names.end(), name) - names.begin();
  };
  Columns columns{find("t"), {}, {}};
  if (columns.time == names.size())
    return content_error(path + ", line 1: expected a column `t`: no CSV of a run");
  for (Eigen::Index i = 0; i < modes; ++i) {
    columns.q.push_back(find(fmt::format("q{}", i)));
    columns.p.push_back(find(fmt::format("p{}", i)));
    if (columns.q.back() == names.size() || columns.p.back() == names.size())
      return content_error(fmt::format(
          "{}, line 1: a start needs q0 to q{} and p0 to p{}: record them with --coordinate all "
          "--velocities",
          path, modes - 1, modes - 1));
  }
  if (find(fmt::format("q{}", modes)) != names.size())
    return content_error(
        fmt::format("{}, line 1: a state of more coordinates than the model's {}", path, modes));
  return columns;
}

// The line nearest to the time, or the last one; 0: there is none. A line without a line end may be
// cut off and is ignored.
struct Found {
  std::size_t line = 0;
  std::string_view text;
};
Found find_row(std::string_view text, const Columns& columns, std::optional<double> time) {
  Found found;
  double nearest = 0.0;
  std::size_t number = 1;
  for (std::size_t at = text.find('\n'); at != std::string_view::npos;) {
    const std::size_t begin = at + 1;
    at = text.find('\n', begin);
    if (at == std::string_view::npos) break;
    ++number;
    const std::string_view line = text.substr(begin, at - begin);
    if (time) {
      const std::vector<std::string_view> cells = cells_of(line);
      double here = 0.0;
      if (columns.time >= cells.size() || !to_number(cells[columns.time], here)) continue;
      if (found.line > 0 && std::abs(here - *time) >= nearest) continue;
      nearest = std::abs(here - *time);
    }
    found = {number, line};
  }
  return found;
}

}  // namespace

Result<State> parse_state_row(std::string_view text, const std::string& path,
                              std::optional<double> time, Eigen::Index modes) {
  const std::string_view head = text.substr(0, text.find('\n'));
  const Result<Columns> columns = find_columns(head, modes, path);
  if (!columns) return columns.error();
  const Found found = find_row(text, *columns, time);
  if (found.line == 0) return content_error(path + ": there is no row");
  const std::vector<std::string_view> cells = cells_of(found.text);
  State state{Eigen::VectorXd(modes), Eigen::VectorXd(modes)};
  for (Eigen::Index i = 0; i < modes; ++i) {
    const std::size_t k = i;
    const std::size_t last = std::max(columns->q[k], columns->p[k]);
    if (last >= cells.size() || !to_number(cells[columns->q[k]], state.q[i]) ||
        !to_number(cells[columns->p[k]], state.p[i]))
      return content_error(
          fmt::format("{}, line {}: q{} and p{} are not finite numbers", path, found.line, i, i));
  }
  return state;
}

}  // namespace tremolo
