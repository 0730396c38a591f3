#include "precompute/sensitivity/damping_fit.h"

#include <algorithm>
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

// A measured ratio or decay.
struct DampingRow {
  double omega = 0.0;  // without damping, rad/s
  bool decay = false;  // value and deviation are of a time, s
  double value = 0.0;
  double deviation = 0.0;  // 0: not known
};

// The value that alpha and beta give, and its derivatives by them.
struct Prediction {
  double value = 0.0;
  Eigen::RowVector2d by;
};
Prediction predict(const DampingRow& row, const VectorXd& constants) {
  // alpha/(2 omega) + beta omega/2, and the decay 1/(ratio omega).
  const Eigen::RowVector2d by(0.5 / row.omega, 0.5 * row.omega);
  const double ratio = by * constants;
  if (!row.decay) return {ratio, by};
  return {1.0 / (ratio * row.omega), -by / (ratio * ratio * row.omega)};
}

// The weighted equations about alpha and beta: data = jacobian * (alpha, beta) to first order.
struct Weighted {
  MatrixXd jacobian;
  VectorXd data;
};
Weighted weighted(const std::vector<DampingRow>& rows, const VectorXd& constants) {
  constexpr double kLeast = 1e-12;  // a ratio of zero has no fraction
  const auto n = std::ssize(rows);
  Weighted result{MatrixXd(n, 2), VectorXd(n)};
  for (Index i = 0; i < n; ++i) {
    const DampingRow& row = rows[static_cast<std::size_t>(i)];
    const Prediction now = predict(row, constants);
    const double scale = row.deviation > 0.0 ? row.deviation : std::max(now.value, kLeast);
    result.jacobian.row(i) = now.by / scale;
    result.data[i] = (row.value - now.value) / scale + result.jacobian.row(i).dot(constants);
  }
  return result;
}

// Both constants, or the better one where both would make one of them negative.
Line solve_not_negative(const Weighted& at, std::vector<Index>& used) {
  used = {0, 1};
  Line best;
  if (at.data.size() >= 2) best = solve(at.jacobian, at.data, used);
  if (std::isfinite(best.chi_squared)) return best;
  const Line mass = solve(at.jacobian, at.data, {0}), stiffness = solve(at.jacobian, at.data, {1});
  const bool by_mass = mass.chi_squared <= stiffness.chi_squared;
  used = {by_mass ? 0 : 1};
  return by_mass ? mass : stiffness;
}

// A start that needs none: the ratios by equal fractions of the measured ones.
VectorXd first_constants(const std::vector<DampingRow>& rows) {
  constexpr double kLeast = 1e-12;
  std::vector<DampingRow> ratios = rows;
  for (DampingRow& row : ratios) {
    if (row.decay) row.value = 1.0 / (row.value * row.omega);
    row.decay = false;
    row.deviation = std::max(row.value, kLeast);
  }
  std::vector<Index> used;
  return solve_not_negative(weighted(ratios, VectorXd::Zero(2)), used).values;
}

struct Constants {
  Line line;
  Weighted at;  // the equations about them
  std::vector<Index> used;
};
Constants fit_constants(const std::vector<DampingRow>& rows) {
  constexpr int kMostMoves = 200;
  constexpr double kSmall = 1e-10;  // of all ratios
  VectorXd constants = first_constants(rows);
  Constants fit;
  for (int i = 0; i < kMostMoves; ++i) {
    fit.at = weighted(rows, constants);
    fit.line = solve_not_negative(fit.at, fit.used);
    if (!fit.line.values.allFinite() || fit.line.values.isZero(0.0)) break;
    double change = 0.0;
    for (const DampingRow& row : rows) {
      const double before = predict(row, constants).value;
      change = std::max(change, std::abs(predict(row, fit.line.values).value / before - 1.0));
    }
    // The time of a decay is far from linear: half the way where the values change by much.
    const double part = change > 0.3 ? 0.5 : 1.0;
    constants += part * (fit.line.values - constants);
    if (change < kSmall) break;
  }
  fit.line.chi_squared = (fit.at.data - fit.at.jacobian * fit.line.values).squaredNorm();
  return fit;
}

}  // namespace

std::optional<DampingFit> fit_damping(const Measurements& measured, const std::vector<int>& modes,
                                      const VectorXd& hertz) {
  std::vector<std::pair<int, double>> known;
  std::vector<DampingRow> rows;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const MeasuredMode& row = measured.rows[i];
    if (!row.ratio) continue;
    const double own = row.frequency ? row.frequency->value : hertz[modes[i]];
    const Uncertain& value = row.decay ? *row.decay : *row.ratio;
    rows.push_back({2.0 * std::numbers::pi * own, bool(row.decay), value.value, value.deviation});
    known.emplace_back(modes[i], row.ratio->value);
  }
  if (rows.empty()) return std::nullopt;
  const Constants best = fit_constants(rows);
  DampingFit fit;
  fit.alpha.value = best.line.values[0];
  fit.beta.value = best.line.values[1];
  fit.chi_squared = best.line.chi_squared;
  fit.freedom = static_cast<int>(std::ssize(rows) - std::ssize(best.used));
  fit.ratios = ratios_by_mode(known, hertz);
  const MatrixXd part = best.at.jacobian(Eigen::all, best.used);
  MatrixXd covariance = (part.transpose() * part).inverse();
  const bool scaled = !measured.ratio_deviations;
  if (scaled && fit.freedom == 0) return fit;
  if (scaled) covariance *= fit.chi_squared / fit.freedom;
  for (std::size_t i = 0; i < best.used.size(); ++i) {
    const auto at = static_cast<Index>(i);
    (best.used[i] == 0 ? fit.alpha : fit.beta).deviation = std::sqrt(covariance(at, at));
  }
  if (best.used.size() == 2)
    fit.correlation = covariance(0, 1) / std::sqrt(covariance(0, 0) * covariance(1, 1));
  return fit;
}

}  // namespace tremolo
