// The table of all methods and their names.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>

#include "common/overflow.h"
#include "common/text.h"
#include "runtime/bodies/reduced/integrators/methods.h"
#include "runtime/bodies/reduced/integrators/solve/halving.h"

namespace tremolo {
namespace {

// The makers that cannot fail return a bare pointer.
template <IntegratorPointer (*kMake)(Model::Pointer, const IntegratorOptions&)>
MadeIntegrator always(Model::Pointer model, const IntegratorOptions& options) {
  return kMake(std::move(model), options);
}

// halves: a step whose solve fails may be subdivided. drifts: the residual of the solve affects the
// energy.
struct Entry {
  std::string_view name;
  IntegratorMaker make;
  bool halves = false;
  bool drifts = false;
};

constexpr std::array kEntries = {
    Entry{"verlet", always<make_verlet>},
    Entry{"midpoint", always<make_midpoint>, true, true},
    Entry{"newmark", always<make_newmark>, true, true},
    Entry{"imexv", make_imexv, true, true},
    Entry{"imexv-thesis", make_imexv_thesis},
    Entry{"imexv-adaptive", make_imexv_adaptive, true, true},
    Entry{"imexv-linear", make_imexv_linear},
    Entry{"imexv-coupled", make_imexv_coupled, true, true},
    Entry{"avf", always<make_avf>, true},
    Entry{"ep2", always<make_ep2>, true},
    Entry{"ep4", always<make_ep4>, true},
    Entry{"verlet4", always<make_verlet4>},
    Entry{"explicit-euler", always<make_explicit_euler>},
    Entry{"implicit-euler", always<make_implicit_euler>, true, true},
    Entry{"rk2", always<make_rk2>},
    Entry{"rk4", always<make_rk4>},
};

constexpr auto kNames = [] {
  std::array<std::string_view, kEntries.size()> names;
  for (std::size_t i = 0; i < names.size(); ++i) names[i] = kEntries[i].name;
  return names;
}();

// A step of second order has the error (h omega)^3/12 of its own motion, and T/h steps are taken:
// the drift falls with h^2 if the residual of the solve falls with h^3. omega is that of the first
// mode, the slowest motion.
double solve_tolerance(const Model& model, const IntegratorOptions& options) {
  constexpr double kShare = 1e-5;   // of (h omega)^3 at which the solve becomes stricter
  constexpr double kLeast = 1e-13;  // rounding
  const double angle = options.step * std::sqrt(std::max(0.0, model.lambda()[0]));
  if (angle == 0.0) return options.tolerance;
  const double stricter = options.tolerance * (angle * angle * angle / kShare);
  return std::min(options.tolerance, std::max(kLeast, stricter));
}

Status refuse(const std::string& what, double value, const char* range) {
  return usage_error(what + " is " + number_text(value) + ", must be " + range);
}

Status check_options(const IntegratorOptions& options, std::size_t modes) {
  const auto not_below_zero = [](double value) { return value >= 0.0 && std::isfinite(value); };
  if (!(options.step > 0.0) || !std::isfinite(options.step))
    return refuse("the step", options.step, "positive and finite (s)");
  if (!not_below_zero(options.alpha))
    return refuse("the damping alpha", options.alpha, "finite and not negative (1/s)");
  if (!not_below_zero(options.beta))
    return refuse("the damping beta", options.beta, "finite and not negative (s)");
  for (const auto& [what, value, unit] : {std::tuple{"the damping alpha", options.alpha, "1/s"},
                                          {"the damping beta", options.beta, "s"}})
    if (overflows(value)) return usage_error(overflow_text(what, value, unit));
  if (const Status s = check_step_size(options.step); !s) return usage_error(s.error().message);
  if (!not_below_zero(options.newmark_beta))
    return refuse("Newmark's beta", options.newmark_beta, "finite and not negative");
  if (!not_below_zero(options.newmark_gamma))
    return refuse("Newmark's gamma", options.newmark_gamma, "finite and not negative");
  if (!(options.tolerance > 0.0) || !std::isfinite(options.tolerance))
    return refuse("the tolerance", options.tolerance, "positive and finite");
  if (options.max_iterations < 1)
    return refuse("the number of iterations", options.max_iterations, "at least 1");
  if (options.halvings < 0) return refuse("the number of halvings", options.halvings, "at least 0");
  return check_ratios(options.ratios, modes);
}

}  // namespace

std::span<const std::string_view> integrator_names() {
  return kNames;
}

MadeIntegrator make_integrator(std::string_view name, Model::Pointer model,
                               const IntegratorOptions& wanted) {
  if (!model) return usage_error("an integrator needs a model");
  if (wanted.beta > 0.0)
    if (const auto strains = model->strain_matrix(); !strains) return strains.error();
  for (const Entry& entry : kEntries) {
    if (entry.name != name) continue;
    const auto modes = static_cast<std::size_t>(model->modes());
    if (Status status = check_options(wanted, modes); !status) return status.error();
    if (model->modes() == 0) return make_rigid_step(entry.name, wanted);
    // For a linear model the solution that ep4 approximates is known.
    if (entry.name == "ep4" && model->potential().linear() && !wanted.moving_frame)
      return make_exact_linear(entry.name, std::move(model), wanted);
    IntegratorOptions options = wanted;
    if (entry.drifts) options.tolerance = solve_tolerance(*model, wanted);
    if (entry.halves && options.halvings > 0)
      return make_halving(entry.make, std::move(model), options);
    return entry.make(std::move(model), options);
  }
  std::string message = "unknown integrator '" + std::string(name) + "'; known:";
  for (const std::string_view known : kNames) message += " " + std::string(known);
  return usage_error(std::move(message));
}

}  // namespace tremolo
