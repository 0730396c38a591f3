#include "runtime/apps/tremolo/output/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace tremolo {

double mean(const std::vector<double>& values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const double high = values[values.size() / 2], low = values[(values.size() - 1) / 2];
  const double middle = std::sqrt(low * high);
  return low == high || !(middle > 0.0 && std::isfinite(middle)) ? low : middle;
}

Fit fit_line(const std::vector<double>& values, double spacing) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const double n = static_cast<double>(values.size());
  Fit fit{mean(values), kUnknown, kUnknown, kUnknown, kUnknown};
  if (values.size() < 2) return fit;
  double xx = 0.0, xy = 0.0, yy = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double x = (static_cast<double>(i) - 0.5 * (n - 1.0)) * spacing;
    const double y = values[i] - fit.mean;
    xx += x * x;
    xy += x * y;
    yy += y * y;
  }
  fit.scatter = std::sqrt(yy / (n - 1.0));
  fit.slope = xy / xx;
  if (values.size() < 3) return fit;
  double left = 0.0;  // summed apart: yy - slope xy would cancel where the line fits
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double x = (static_cast<double>(i) - 0.5 * (n - 1.0)) * spacing;
    const double off = values[i] - fit.mean - fit.slope * x;
    left += off * off;
  }
  fit.slope_error = std::sqrt(left / (n - 2.0) / xx);
  fit.explained = 1.0 - left / yy;
  return fit;
}

}  // namespace tremolo
