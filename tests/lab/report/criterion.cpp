#include "tests/lab/report/criterion.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/result.h"
#include "runtime/apps/tremolo/output/tell.h"

namespace tremolo {

Criterion at_most(std::string what, double measured, double bound, const std::string& who,
                  const std::string& bound_text) {
  return {std::move(what), "<= " + (bound_text.empty() ? fmt::format("{:.3g}", bound) : bound_text),
          fmt::format("{:.3g}", measured) + (who.empty() ? "" : " (" + who + ")"),
          measured <= bound};
}

std::string_view verdict(const Criterion& criterion) {
  if (criterion.elsewhere) return "elsewhere";
  if (!criterion.decides) return "shown";
  return criterion.met ? "met" : "MISSED";
}

std::string verdict(const std::vector<Criterion>& criteria) {
  std::vector<std::string_view> missed;
  std::ptrdiff_t met = 0, shown = 0, elsewhere = 0;
  for (const Criterion& criterion : criteria) {
    const std::string_view word = verdict(criterion);
    met += word == "met" ? 1 : 0;
    shown += word == "shown" ? 1 : 0;
    elsewhere += word == "elsewhere" ? 1 : 0;
    if (word == "MISSED") missed.push_back(criterion.what);
  }
  std::string text = fmt::format("{} of {} criteria are met", met,
                                 met + static_cast<std::ptrdiff_t>(missed.size()));
  if (!missed.empty()) text += fmt::format("; missed: {}", fmt::join(missed, "; "));
  text += ".";
  if (shown > 0) text += fmt::format(" Shown without a bound: {}.", shown);
  if (elsewhere > 0) text += fmt::format(" Measured by another command: {}.", elsewhere);
  return text;
}

int exit_code(const std::vector<Criterion>& criteria) {
  const bool missed = std::ranges::any_of(
      criteria, [](const Criterion& criterion) { return verdict(criterion) == "MISSED"; });
  return missed ? static_cast<int>(ErrorKind::kCriterion) : 0;
}

nlohmann::ordered_json to_json(const std::vector<Criterion>& criteria) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const Criterion& criterion : criteria)
    json.push_back({{"what", criterion.what},
                    {"bound", criterion.bound},
                    {"measured", criterion.measured},
                    {"met", criterion.met},
                    {"decides", criterion.decides}});
  return json;
}

void print(const std::vector<Criterion>& criteria) {
  for (const Criterion& criterion : criteria)
    tell("  {:<9} {}: {} ({})\n", verdict(criterion), criterion.what, criterion.measured,
         criterion.bound);
}

}  // namespace tremolo
