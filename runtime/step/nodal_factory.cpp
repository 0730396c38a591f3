#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/text.h"
#include "runtime/step/halved_step.h"

namespace tremolo {
namespace {

constexpr double kAlways = std::numeric_limits<double>::infinity();
constexpr std::array<std::string_view, 12> kNodalNames = {"explicit-euler",
                                                          "symplectic-euler",
                                                          "explicit-midpoint",
                                                          "rk4",
                                                          "implicit-euler",
                                                          "midpoint",
                                                          "implicit-euler-linear",
                                                          "implicit-euler-sweep",
                                                          "newmark",
                                                          "bdf2",
                                                          "imex",
                                                          "energy"};

bool is_explicit(std::string_view name) {
  return name == "explicit-euler" || name == "symplectic-euler" || name == "explicit-midpoint" ||
         name == "rk4" || name == "implicit-euler-sweep";
}

}  // namespace

std::span<const std::string_view> nodal_integrator_names() {
  return kNodalNames;
}

Result<std::unique_ptr<NodalIntegrator>> make_nodal_integrator(std::string_view name,
                                                               const NodalSystem& system,
                                                               const NodalOptions& options) {
  const auto known = std::find(kNodalNames.begin(), kNodalNames.end(), name);
  if (known == kNodalNames.end()) {
    std::string names;
    for (const std::string_view each : kNodalNames)
      names += (names.empty() ? "" : ", ") + std::string(each);
    return usage_error("no method of cloth is called '" + std::string(name) + "'; there are " +
                       names);
  }
  if (!(options.step > 0.0) || !std::isfinite(options.step))
    return usage_error("the step is " + number_text(options.step) +
                       " s, must be positive and finite");
  if (!(options.tolerance > 0.0) || !std::isfinite(options.tolerance))
    return usage_error("the tolerance is " + number_text(options.tolerance) +
                       ", must be positive and finite");
  if (options.max_iterations < 1 || options.halvings < 0 || options.halvings > 20)
    return usage_error("a step takes at least one iteration and is halved 0 to 20 times");
  if (is_explicit(*known)) return make_explicit(*known, system, options);
  if (*known == "imex") return make_split(system, options);
  return make_implicit(*known, system, options);
}

double stability_number(std::string_view name) {
  if (name == "explicit-euler" || name == "explicit-midpoint") return 0.0;
  if (name == "symplectic-euler" || name == "imex") return 2.0;
  if (name == "rk4") return 2.0 * std::numbers::sqrt2;
  // Limit of x1 = x0 + h v1, v1 = v0 + h a(x0 + h v0): a root of its step reaches -1 at y^2 = 4/3.
  return name == "implicit-euler-sweep" ? 2.0 / std::numbers::sqrt3 : kAlways;
}

}  // namespace tremolo
