#include "runtime/program/start/load_search.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace tremolo {
namespace {

constexpr int kAttempts = 30;
constexpr double kNear = 0.01;  // relative, of the amplitude

double four_digits(double value) {
  return std::stod(fmt::format("{:.4g}", value));
}

// Secant steps on logarithms, kept inside the bracket once there is one.
class Search {
 public:
  explicit Search(double wanted) : wanted_(wanted) {}

  void take(const LoadAttempt& attempt) {
    LoadAttempt& side = attempt.amplitude < wanted_ ? low_ : high_;
    side = attempt;
  }

  double next(const LoadAttempt& last) const {
    if (high_.scale == 0.0) return last.scale * std::clamp(wanted_ / last.amplitude, 1.05, 10.0);
    if (low_.scale == 0.0)
      return std::isfinite(last.amplitude)
                 ? last.scale * std::clamp(wanted_ / last.amplitude, 0.1, 0.95)
                 : 0.1 * last.scale;
    const double width = std::log(high_.scale / low_.scale);
    const double slope = std::log(high_.amplitude / low_.amplitude);
    const double part = std::isfinite(slope) ? std::log(wanted_ / low_.amplitude) / slope : 0.5;
    return low_.scale * std::exp(width * std::clamp(part, 0.1, 0.9));
  }

  bool closed() const {
    return low_.scale > 0.0 && high_.scale > 0.0 && high_.scale < 1.002 * low_.scale;
  }

  std::string trouble() const {
    if (!high_.reason.empty())
      return fmt::format("with {:.4g} times the load, at {:.3g} of the size: {}", low_.scale,
                         low_.amplitude, "the next larger one breaks off: " + high_.reason);
    return fmt::format(
        "the displacement jumps from {:.3g} to {:.3g} of the size near {:.4g} times "
        "the load",
        low_.amplitude, high_.amplitude, high_.scale);
  }

 private:
  double wanted_;
  LoadAttempt low_, high_;
};

}  // namespace

Result<LoadScale> search_load_scale(double wanted,
                                    const std::function<Result<LoadAttempt>(double)>& attempt) {
  Search search(wanted);
  double scale = 1e-2;
  for (int i = 0; i < kAttempts && !search.closed(); ++i) {
    const Result<LoadAttempt> result = attempt(four_digits(scale));
    if (!result) return result.error();
    if (!(result->amplitude > 0.0)) return LoadScale{0.0, "the load does not move it"};
    if (std::abs(result->amplitude / wanted - 1.0) <= kNear) return LoadScale{result->scale, ""};
    search.take(*result);
    scale = search.next(*result);
  }
  return LoadScale{0.0, search.trouble()};
}

}  // namespace tremolo
