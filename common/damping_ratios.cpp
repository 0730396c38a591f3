#include "common/damping_ratios.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/text.h"

namespace tremolo {
namespace {

// One item of the list: Z or F:Z. frequency: 0 without one.
bool read_item(std::string_view item, RatioAt& out) {
  const std::size_t colon = item.find(':');
  if (colon != std::string_view::npos) {
    const auto [stop, error] = read_decimal(item.data(), item.data() + colon, out.frequency);
    if (error != std::errc{} || stop != item.data() + colon) return false;
    item.remove_prefix(colon + 1);
  }
  const bool percent = item.ends_with('%');
  if (percent) item.remove_suffix(1);
  const auto [stop, error] = read_decimal(item.data(), item.data() + item.size(), out.ratio);
  if (percent) out.ratio *= 0.01;
  return error == std::errc{} && stop == item.data() + item.size();
}

Status check_table(const std::vector<RatioAt>& table, const std::string& shown) {
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double f = table[i].frequency;
    if (!(f > 0.0) || !std::isfinite(f))
      return content_error(shown + "a frequency must be positive and finite");
    if (i > 0 && f <= table[i - 1].frequency)
      return content_error(shown + "the frequencies must ascend");
  }
  return Success{};
}

}  // namespace

Result<DampingRatios> parse_damping(std::string_view text) {
  const std::string shown = "damping ratios " + std::string(text) + ": ";
  const Error wrong = usage_error(
      shown +
      "expected a fraction of critical damping for every mode (2% or 0.02), one for each mode "
      "(2%,1%,0.5%), F1:Z1,F2:Z2 with frequencies in Hz, or three such pairs and more");
  std::vector<RatioAt> items;
  std::size_t pairs = 0;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    const std::string_view item = text.substr(at, end - at);
    RatioAt read;
    if (!read_item(item, read)) return wrong;
    if (item.find(':') != std::string_view::npos) ++pairs;
    items.push_back(read);
    at = end + 1;
  }
  if ((pairs != 0 && pairs != items.size()) || pairs == 1) return wrong;
  for (const RatioAt& item : items)
    if (!(item.ratio >= 0.0) || !(item.ratio < 1.0))
      return content_error(shown + "a ratio is a fraction of critical damping, from 0 to below 1");
  DampingRatios ratios;
  if (pairs == 2) {
    Status s = take(ratios.rayleigh, rayleigh_damping(items[0].frequency, items[0].ratio,
                                                      items[1].frequency, items[1].ratio, text));
    if (!s) return s.error();
  } else if (pairs > 2) {
    if (Status s = check_table(items, shown); !s) return s.error();
    ratios.table = std::move(items);
  } else {
    for (const RatioAt& item : items) ratios.of_modes.push_back(item.ratio);
  }
  return ratios;
}

double ratio_of(const DampingRatios& ratios, std::size_t mode, double frequency) {
  if (!ratios.of_modes.empty()) return ratios.of_modes[std::min(mode, ratios.of_modes.size() - 1)];
  const std::vector<RatioAt>& table = ratios.table;
  if (table.empty()) return 0.0;
  if (frequency <= table.front().frequency) return table.front().ratio;
  if (frequency >= table.back().frequency) return table.back().ratio;
  const auto above =
      std::upper_bound(table.begin(), table.end(), frequency,
                       [](double f, const RatioAt& row) { return f < row.frequency; });
  const RatioAt &a = *(above - 1), &b = *above;
  return a.ratio + (b.ratio - a.ratio) * (frequency - a.frequency) / (b.frequency - a.frequency);
}

}  // namespace tremolo
