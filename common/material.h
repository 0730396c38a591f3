// An isotropic St. Venant-Kirchhoff material.
#pragma once

#include <cmath>
#include <string>

#include "common/result.h"

namespace tremolo {

// young: Pa; poisson: dimensionless; density: kg/m^3.
struct Material {
  double young = 1e6;
  double poisson = 0.45;
  double density = 1000.0;
};

// First and second Lame constants, Pa.
inline double lame_lambda(const Material& material) {
  return material.young * material.poisson /
         ((1.0 + material.poisson) * (1.0 - 2.0 * material.poisson));
}
inline double lame_mu(const Material& material) {
  return material.young / (2.0 * (1.0 + material.poisson));
}

// The energy is positive exactly for E > 0 and -1 < nu < 1/2; the mass for rho > 0.
inline Status check_material(const Material& material) {
  const auto refuse = [](const char* what, double value, const char* range) {
    return content_error(std::string(what) + " is " + std::to_string(value) + ", must be " + range);
  };
  if (!(material.young > 0.0) || !std::isfinite(material.young))
    return refuse("Young's modulus", material.young, "positive and finite (Pa)");
  if (!(material.poisson > -1.0 && material.poisson < 0.5))
    return refuse("Poisson's ratio", material.poisson, "above -1 and below 0.5");
  if (!(material.density > 0.0) || !std::isfinite(material.density))
    return refuse("the density", material.density, "positive and finite (kg/m^3)");
  return Success{};
}

}  // namespace tremolo
