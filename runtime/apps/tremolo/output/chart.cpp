#include "runtime/apps/tremolo/output/chart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include <fmt/format.h>

namespace tremolo {
namespace {

using OrderedJson = nlohmann::ordered_json;

double nine_digits(double value) {
  return std::strtod(fmt::format("{:.9g}", value).c_str(), nullptr);
}

bool can_stand_on(double value, bool logarithmic) {
  return std::isfinite(value) && (!logarithmic || value > 0.0);
}

const char* name_of(CurveStyle style) {
  constexpr const char* kNames[] = {"lines", "lines and points", "points", "dashes"};
  return kNames[static_cast<int>(style)];
}

OrderedJson range(const std::optional<std::pair<double, double>>& range) {
  return range ? OrderedJson{range->first, range->second} : OrderedJson();
}

}  // namespace

OrderedJson to_json(const Chart& chart) {
  OrderedJson curves = OrderedJson::array();
  for (const Curve& curve : chart.curves) {
    OrderedJson x = OrderedJson::array(), y = OrderedJson::array();
    for (std::size_t i = 0; i < std::min(curve.x.size(), curve.y.size()); ++i) {
      const bool drawn =
          can_stand_on(curve.x[i], chart.log_x) && can_stand_on(curve.y[i], chart.log_y);
      x.push_back(drawn ? OrderedJson(nine_digits(curve.x[i])) : OrderedJson());
      y.push_back(drawn ? OrderedJson(nine_digits(curve.y[i])) : OrderedJson());
    }
    curves.push_back({{"label", curve.label},
                      {"style", name_of(curve.style)},
                      {"colour", curve.colour},
                      {"x", std::move(x)},
                      {"y", std::move(y)}});
    if (!curve.loops.empty()) curves.back()["loops"] = curve.loops;
  }
  return {{"title", chart.title},
          {"x_label", chart.x_label},
          {"y_label", chart.y_label},
          {"log_x", chart.log_x},
          {"log_y", chart.log_y},
          {"zero", chart.zero},
          {"time", chart.time},
          {"x_range", range(chart.x_range)},
          {"y_range", range(chart.y_range)},
          {"curves", std::move(curves)}};
}

OrderedJson to_json(const CellChart& chart) {
  OrderedJson classes = OrderedJson::array();
  for (const auto& [label, colour] : chart.classes)
    classes.push_back({{"label", label}, {"colour", colour}});
  return {{"title", chart.title},     {"x_label", chart.x_label},     {"y_label", chart.y_label},
          {"columns", chart.columns}, {"rows", chart.rows},           {"values", chart.values},
          {"marks", chart.marks},     {"classes", std::move(classes)}};
}

void thin(std::vector<double>& x, std::vector<double>& y, std::size_t buckets) {
  const std::size_t size = std::min(x.size(), y.size());
  if (buckets == 0 || size <= 4 * buckets) return;
  std::vector<double> kept_x, kept_y;
  for (std::size_t b = 0; b < buckets; ++b) {
    const std::size_t begin = b * size / buckets, end = (b + 1) * size / buckets;
    std::array<std::size_t, 4> keep = {begin, begin, begin, end - 1};
    for (std::size_t i = begin; i < end; ++i) {
      // Any number replaces one that is not a number.
      if (y[i] < y[keep[1]] || std::isnan(y[keep[1]])) keep[1] = i;
      if (y[i] > y[keep[2]] || std::isnan(y[keep[2]])) keep[2] = i;
    }
    std::sort(keep.begin(), keep.end());
    for (auto i = keep.begin(); i != std::unique(keep.begin(), keep.end()); ++i) {
      kept_x.push_back(x[*i]);
      kept_y.push_back(y[*i]);
    }
  }
  x = std::move(kept_x);
  y = std::move(kept_y);
}

}  // namespace tremolo
