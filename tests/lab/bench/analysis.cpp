#include <algorithm>
#include <cmath>
#include <limits>

#include "runtime/program/output/statistics.h"
#include "tests/lab/bench/precision.h"

namespace tremolo::bench {

std::optional<Cost> cost_of_error(std::span<const Entry> curve, double target, double gap) {
  const auto error = [&](const Entry& entry) { return std::max(entry.error, kAbove * gap); };
  std::optional<Cost> best;
  const auto offer = [&](Cost cost) {
    if (std::isfinite(cost.value) && (!best || cost.value < best->value)) best = cost;
  };
  for (std::size_t i = 0; i < curve.size(); ++i) {
    if (!(error(curve[i]) <= target)) continue;
    if (i == 0) {
      offer({curve[i].cost(), true});
      continue;
    }
    const double before = error(curve[i - 1]), after = error(curve[i]);
    if (before <= target) continue;
    // Where the longer step broke off, or was not timed, there is nothing to interpolate with.
    if (!std::isfinite(before) || !std::isfinite(curve[i - 1].cost())) {
      offer({curve[i].cost(), false});
      continue;
    }
    const double part = std::log(before / target) / std::log(before / after);
    const double rise = std::log(curve[i].cost() / curve[i - 1].cost());
    offer({curve[i - 1].cost() * std::exp(part * rise), false});
  }
  return best;
}

std::vector<double> cost_ratios(const Precision& precision, const std::string& method,
                                const std::string& other, double target) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < precision.scenes.size(); ++i) {
    if (!precision.measured(i)) continue;
    const double gap = precision.references[i].gap;
    const std::optional<Cost> mine = cost_of_error(precision.curve(i, method), target, gap);
    const std::optional<Cost> theirs = cost_of_error(precision.curve(i, other), target, gap);
    if (mine && theirs)
      ratios.push_back(theirs->value / mine->value);
    else if (mine)
      ratios.push_back(std::numeric_limits<double>::infinity());
    else if (theirs)
      ratios.push_back(0.0);
  }
  return ratios;
}

std::vector<Standing> standings(const Precision& precision, double target) {
  std::vector<Standing> table;
  std::vector<std::vector<double>> slowdowns(precision.integrators.size());
  for (const std::string& integrator : precision.integrators)
    table.push_back({integrator, 0, 0, 0, 0.0});
  for (std::size_t i = 0; i < precision.scenes.size(); ++i) {
    if (!precision.measured(i)) continue;
    std::vector<double> costs;
    for (const std::string& integrator : precision.integrators) {
      const auto cost =
          cost_of_error(precision.curve(i, integrator), target, precision.references[i].gap);
      costs.push_back(cost ? cost->value : std::numeric_limits<double>::infinity());
    }
    const double best = *std::min_element(costs.begin(), costs.end());
    for (std::size_t m = 0; m < costs.size(); ++m) {
      ++table[m].scenes;
      if (!std::isfinite(costs[m])) continue;
      ++table[m].reached;
      if (costs[m] == best) ++table[m].wins;
      slowdowns[m].push_back(costs[m] / best);
    }
  }
  for (std::size_t m = 0; m < table.size(); ++m) table[m].slowdown = median(slowdowns[m]);
  std::stable_sort(table.begin(), table.end(), [](const Standing& a, const Standing& b) {
    if (a.reached != b.reached) return a.reached > b.reached;
    return a.slowdown < b.slowdown;
  });
  return table;
}

}  // namespace tremolo::bench
