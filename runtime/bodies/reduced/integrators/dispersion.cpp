#include "runtime/bodies/reduced/integrators/dispersion.h"

#include <cmath>
#include <complex>
#include <limits>

#include "runtime/bodies/reduced/integrators/methods.h"
#include "runtime/bodies/reduced/integrators/solve/inertia_filter.h"

namespace tremolo {
namespace {

// cosine: half the trace of a step.
std::optional<double> angle_of(double cosine) {
  if (!(cosine > -1.0)) return std::nullopt;
  return std::acos(std::min(cosine, 1.0));
}

// For the polynomial of e^{iz} that an explicit method computes, with this number of terms.
double angle_of_series(double z, int terms) {
  std::complex<double> sum = 1.0, term = 1.0;
  for (int k = 1; k <= terms; ++k) {
    term *= std::complex<double>(0.0, z) / static_cast<double>(k);
    sum += term;
  }
  return std::arg(sum);
}

}  // namespace

std::optional<double> step_angle(std::string_view method, double z,
                                 const IntegratorOptions& options, bool linear) {
  const auto midpoint = [z](double weight) { return 2.0 * std::atan(0.5 * z / weight); };
  if (method == "ep4") return linear ? z : midpoint(rational_weight(0.5 * z));
  if (method == "ep2") return midpoint(cotangent_weight(0.5 * z));
  if (method == "avf" || method == "midpoint") return midpoint(1.0);
  if (method == "newmark")
    return angle_of(1.0 - 0.5 * z * z / (1.0 + options.newmark_beta * z * z));
  if (method == "verlet") return angle_of(1.0 - 0.5 * z * z);
  if (method.starts_with("imexv"))
    return z < 2.0 * options.split.safety ? angle_of(1.0 - 0.5 * z * z) : midpoint(1.0);
  if (method == "verlet4") return angle_of(verlet4_cosine(z));
  if (method.ends_with("euler")) return std::atan(z);
  if (method == "rk2") return angle_of_series(z, 2);
  if (method == "rk4") return angle_of_series(z, 4);
  return std::nullopt;
}

double frequency_error(std::string_view method, double z, const IntegratorOptions& options,
                       bool linear) {
  if (z == 0.0) return 0.0;
  const std::optional<double> angle = step_angle(method, z, options, linear);
  return angle ? std::abs(*angle / z - 1.0) : std::numeric_limits<double>::infinity();
}

}  // namespace tremolo
