#include "runtime/split.h"

#include <charconv>
#include <cmath>
#include <numbers>
#include <string>

#include "common/text.h"

namespace tremolo {
namespace {

// The largest explicit omega, rad/s, exclusive.
double explicit_bound(double step, const SplitOptions& options) {
  if (options.rule == SplitRule::kThesis) return 2.0 * std::numbers::pi / step;
  return 2.0 * options.safety / step;
}

}  // namespace

Result<Split> choose_split(const Eigen::VectorXd& lambda, double step,
                           const SplitOptions& options) {
  const Eigen::Index r = lambda.size();
  if (options.rule == SplitRule::kCount) {
    if (options.count < 0 || options.count > r)
      return usage_error("the split asks for " + std::to_string(options.count) +
                         " explicit coordinates; the model has " + std::to_string(r));
    return Split{options.count, r - options.count};
  }
  if (!(options.safety > 0.0 && options.safety <= 1.0))
    return usage_error("the split's safety is " + number_text(options.safety) +
                       ", must be above 0 and at most 1");
  const double bound = explicit_bound(step, options);
  Eigen::Index low = 0;
  while (low < r && std::sqrt(lambda[low]) < bound) ++low;
  return Split{low, r - low};
}

Result<SplitOptions> parse_split(std::string_view text) {
  SplitOptions options;
  if (text == "default") return options;
  if (text == "thesis") {
    options.rule = SplitRule::kThesis;
    return options;
  }
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), options.count);
  if (code != std::errc() || end != text.data() + text.size() || options.count < 0)
    return usage_error("the split is '" + std::string(text) +
                       "', must be default, thesis or a count of explicit coordinates");
  options.rule = SplitRule::kCount;
  return options;
}

}  // namespace tremolo
