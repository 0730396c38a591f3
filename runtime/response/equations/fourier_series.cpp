#include "runtime/response/equations/fourier_series.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tremolo {

Eigen::VectorXd fourier_row(Eigen::Index harmonics, double theta) {
  Eigen::VectorXd row(2 * harmonics + 1);
  row[0] = 1.0;
  for (Eigen::Index k = 1; k <= harmonics; ++k) {
    row[cosine_column(k)] = std::cos(static_cast<double>(k) * theta);
    row[sine_column(k)] = std::sin(static_cast<double>(k) * theta);
  }
  return row;
}

Eigen::VectorXd fourier_slope_row(Eigen::Index harmonics, double theta) {
  Eigen::VectorXd row(2 * harmonics + 1);
  row[0] = 0.0;
  for (Eigen::Index k = 1; k <= harmonics; ++k) {
    const auto order = static_cast<double>(k);
    row[cosine_column(k)] = -order * std::sin(order * theta);
    row[sine_column(k)] = order * std::cos(order * theta);
  }
  return row;
}

FourierSeries with_harmonics(const FourierSeries& series, Eigen::Index harmonics) {
  FourierSeries result = FourierSeries::Zero(series.rows(), 2 * harmonics + 1);
  const Eigen::Index kept = std::min(series.cols(), result.cols());
  result.leftCols(kept) = series.leftCols(kept);
  return result;
}

FourierSeries shifted(const FourierSeries& series, double shift) {
  FourierSeries result = series;
  for (Eigen::Index k = 1; k <= harmonics_of(series); ++k) {
    const double c = std::cos(static_cast<double>(k) * shift);
    const double s = std::sin(static_cast<double>(k) * shift);
    const auto a = series.col(cosine_column(k)), b = series.col(sine_column(k));
    result.col(cosine_column(k)) = c * a + s * b;
    result.col(sine_column(k)) = c * b - s * a;
  }
  return result;
}

FourierSeries odd_harmonics(const FourierSeries& series) {
  FourierSeries result = FourierSeries::Zero(series.rows(), series.cols());
  for (Eigen::Index k = 1; k <= harmonics_of(series); k += 2)
    result.middleCols(cosine_column(k), 2) = series.middleCols(cosine_column(k), 2);
  return result;
}

FourierSeries doubled_period(const FourierSeries& series) {
  const Eigen::Index H = harmonics_of(series);
  FourierSeries result = FourierSeries::Zero(series.rows(), 4 * H + 1);
  result.col(0) = series.col(0);
  for (Eigen::Index k = 1; k <= H; ++k)
    result.middleCols(cosine_column(2 * k), 2) = series.middleCols(cosine_column(k), 2);
  return result;
}

FourierSeries halved_period(const FourierSeries& series) {
  const Eigen::Index H = harmonics_of(series) / 2;
  FourierSeries result(series.rows(), 2 * H + 1);
  result.col(0) = series.col(0);
  for (Eigen::Index k = 1; k <= H; ++k)
    result.middleCols(cosine_column(k), 2) = series.middleCols(cosine_column(2 * k), 2);
  return result;
}

double harmonic_size(const FourierSeries& series, Eigen::Index k) {
  if (k == 0) return series.col(0).norm();
  return std::sqrt(0.5 * (series.col(cosine_column(k)).squaredNorm() +
                          series.col(sine_column(k)).squaredNorm()));
}

double last_share(const FourierSeries& series) {
  const Eigen::Index H = harmonics_of(series);
  const double all = series.rightCols(2 * H).norm();
  if (!(all > 0.0)) return 0.0;
  if (H == 1) return 1.0;
  return series.rightCols(std::min<Eigen::Index>(4, 2 * (H - 1))).norm() / all;
}

PeriodicPeak largest_over_period(const Eigen::MatrixXd& rows, const FourierSeries& series) {
  const FourierSeries seen = rows * series;
  const Eigen::Index H = harmonics_of(seen);
  const auto square = [&](double theta) { return (seen * fourier_row(H, theta)).squaredNorm(); };
  // x . x', whose zeros are the extremes of |x|^2.
  const auto slope = [&](double theta) {
    return (seen * fourier_row(H, theta)).dot(seen * fourier_slope_row(H, theta));
  };
  const Eigen::Index samples = 16 * (H + 1);
  const double spacing = 2.0 * std::numbers::pi / static_cast<double>(samples);
  Eigen::VectorXd squares(samples);
  for (Eigen::Index n = 0; n < samples; ++n) squares[n] = square(static_cast<double>(n) * spacing);
  double best = 0.0, at = 0.0;
  for (Eigen::Index n = 0; n < samples; ++n) {
    const double here = squares[n];
    if (here < squares[(n + 1) % samples] || here < squares[(n + samples - 1) % samples]) continue;
    if (here < 0.9 * best) continue;
    double low = static_cast<double>(n - 1) * spacing, high = static_cast<double>(n + 1) * spacing;
    for (int i = 0; i < 50 && high - low > 1e-12; ++i) {
      const double middle = 0.5 * (low + high);
      (slope(middle) > 0.0 ? low : high) = middle;
    }
    const double theta = 0.5 * (low + high), refined = square(theta);
    if (refined > best) best = refined, at = theta;
  }
  const double turn = 2.0 * std::numbers::pi;
  return {std::sqrt(best), at - turn * std::floor(at / turn)};
}

}  // namespace tremolo
