#include "precompute/sensitivity/damping_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <Eigen/Dense>

#include "common/damping_ratios.h"
#include "common/text.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Line {
  VectorXd values;  // alpha, beta
  double chi_squared = std::numeric_limits<double>::infinity();
};

// Least squares with the columns that are used; infinite if a value would be negative.
Line solve(const MatrixXd& jacobian, const VectorXd& data, const std::vector<Index>& used) {
  const MatrixXd part = jacobian(Eigen::all, used);
  const VectorXd scale = part.colwise().norm();
  const MatrixXd scaled = part * scale.cwiseInverse().asDiagonal();
  const VectorXd found = scaled.colPivHouseholderQr().solve(data);
  Line line{VectorXd::Zero(2), 0.0};
  for (std::size_t i = 0; i < used.size(); ++i) {
    const double value = found[static_cast<Index>(i)] / scale[static_cast<Index>(i)];
    if (!(value >= 0.0)) return {};
    line.values[used[i]] = value;
  }
  line.chi_squared = (data - jacobian * line.values).squaredNorm();
  return line;
}

std::string ratios_by_mode(std::vector<std::pair<int, double>> known, const VectorXd& hertz) {
  std::sort(known.begin(), known.end());
  DampingRatios table;
  for (const auto& [mode, ratio] : known) table.table.push_back({hertz[mode], ratio});
  std::sort(table.table.begin(), table.table.end(),
            [](const RatioAt& a, const RatioAt& b) { return a.frequency < b.frequency; });
  std::string list;
  for (int mode = 0; mode <= known.back().first; ++mode) {
    const auto own = std::find_if(known.begin(), known.end(),
                                  [mode](const auto& row) { return row.first == mode; });
    const double ratio = own != known.end()
                             ? own->second
                             : ratio_of(table, static_cast<std::size_t>(mode), hertz[mode]);
    list += (list.empty() ? "" : ",") + number_text(ratio);
  }
  return list;
}

}  // namespace

std::optional<DampingFit> fit_damping(const Measurements& measured, const std::vector<int>& modes,
                                      const VectorXd& hertz) {
  std::vector<std::pair<int, double>> known;
  std::vector<std::array<double, 3>> rows;  // omega, ratio, deviation
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const MeasuredMode& row = measured.rows[i];
    if (!row.ratio) continue;
    const double own = row.frequency ? row.frequency->value : hertz[modes[i]];
    const double least = 1e-12;  // a ratio of zero has no fraction
    rows.push_back(
        {2.0 * std::numbers::pi * own, row.ratio->value,
         row.ratio->deviation > 0.0 ? row.ratio->deviation : std::max(row.ratio->value, least)});
    known.emplace_back(modes[i], row.ratio->value);
  }
  if (rows.empty()) return std::nullopt;
  const auto n = std::ssize(rows);
  MatrixXd jacobian(n, 2);
  VectorXd data(n);
  for (Index i = 0; i < n; ++i) {
    const auto& [omega, ratio, deviation] = rows[static_cast<std::size_t>(i)];
    jacobian.row(i) << 0.5 / (omega * deviation), 0.5 * omega / deviation;
    data[i] = ratio / deviation;
  }
  std::vector<Index> used = {0, 1};
  Line best;
  if (n >= 2) best = solve(jacobian, data, used);
  if (!std::isfinite(best.chi_squared)) {
    const Line mass = solve(jacobian, data, {0}), stiffness = solve(jacobian, data, {1});
    const bool by_mass = mass.chi_squared <= stiffness.chi_squared;
    best = by_mass ? mass : stiffness;
    used = {by_mass ? 0 : 1};
  }
  DampingFit fit;
  fit.alpha.value = best.values[0];
  fit.beta.value = best.values[1];
  fit.chi_squared = best.chi_squared;
  fit.freedom = static_cast<int>(n - std::ssize(used));
  fit.ratios = ratios_by_mode(known, hertz);
  const MatrixXd part = jacobian(Eigen::all, used);
  MatrixXd covariance = (part.transpose() * part).inverse();
  const bool scaled = !measured.ratio_deviations;
  if (scaled && fit.freedom == 0) return fit;
  if (scaled) covariance *= fit.chi_squared / fit.freedom;
  for (std::size_t i = 0; i < used.size(); ++i) {
    const auto at = static_cast<Index>(i);
    (used[i] == 0 ? fit.alpha : fit.beta).deviation = std::sqrt(covariance(at, at));
  }
  if (used.size() == 2)
    fit.correlation = covariance(0, 1) / std::sqrt(covariance(0, 0) * covariance(1, 1));
  return fit;
}

}  // namespace tremolo
