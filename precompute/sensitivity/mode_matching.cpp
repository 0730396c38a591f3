#include "precompute/sensitivity/mode_matching.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace tremolo {
namespace {

// Ascending values `wanted` to ascending values `offered`, each to another one: the index of each,
// with the least sum of squared distances. At most as many are wanted as offered.
std::vector<std::size_t> match_ascending(const std::vector<double>& wanted,
                                         const std::vector<double>& offered) {
  const std::size_t n = wanted.size(), m = offered.size();
  constexpr double kNever = std::numeric_limits<double>::infinity();
  // cost[i][j]: of the first i wanted ones among the first j offered ones.
  std::vector<std::vector<double>> cost(n + 1, std::vector<double>(m + 1, kNever));
  std::fill(cost[0].begin(), cost[0].end(), 0.0);
  for (std::size_t i = 1; i <= n; ++i)
    for (std::size_t j = i; j <= m; ++j) {
      const double distance = wanted[i - 1] - offered[j - 1];
      cost[i][j] = std::min(cost[i][j - 1], cost[i - 1][j - 1] + distance * distance);
    }
  std::vector<std::size_t> found(n);
  for (std::size_t i = n, j = m; i > 0; --j) {
    if (j > i && cost[i][j] == cost[i][j - 1]) continue;
    found[--i] = j - 1;
  }
  return found;
}

}  // namespace

Result<std::vector<int>> match_modes(const std::vector<MeasuredMode>& rows,
                                     const Eigen::VectorXd& hertz) {
  const auto available = static_cast<int>(hertz.size());
  std::vector<int> modes(rows.size(), -1);
  std::vector<char> taken(static_cast<std::size_t>(available), 0);
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!rows[i].mode) {
      open.push_back(i);
      continue;
    }
    modes[i] = *rows[i].mode;
    if (modes[i] >= available)
      return content_error("mode " + std::to_string(modes[i] + 1) + " is measured, but only " +
                           std::to_string(available) +
                           " are computed: give --linear-modes K, larger");
    taken[static_cast<std::size_t>(modes[i])] = 1;
  }
  std::sort(open.begin(), open.end(), [&rows](std::size_t a, std::size_t b) {
    return rows[a].frequency->value < rows[b].frequency->value;
  });
  std::vector<double> wanted, offered;
  std::vector<int> left;
  for (const std::size_t i : open) wanted.push_back(std::log(rows[i].frequency->value));
  for (int mode = 0; mode < available; ++mode) {
    if (taken[static_cast<std::size_t>(mode)] != 0) continue;
    left.push_back(mode);
    offered.push_back(std::log(hertz[mode]));
  }
  if (wanted.size() > offered.size())
    return content_error(std::to_string(rows.size()) + " modes are measured, but only " +
                         std::to_string(available) +
                         " are computed: give --linear-modes K, larger");
  const std::vector<std::size_t> found = match_ascending(wanted, offered);
  for (std::size_t k = 0; k < open.size(); ++k) modes[open[k]] = left[found[k]];
  return modes;
}

}  // namespace tremolo
