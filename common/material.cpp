#include "common/material.h"

#include <cmath>
#include <numbers>
#include <string>

#include <Eigen/Geometry>

#include "common/damping_ratios.h"
#include "common/text.h"

namespace tremolo {
namespace {

constexpr const char* kYoung[] = {"E1", "E2", "E3"};
constexpr const char* kPoisson[] = {"nu12", "nu23", "nu31"};
constexpr const char* kShear[] = {"G12", "G23", "G31"};

bool is_positive(double value) {
  return value > 0.0 && std::isfinite(value);
}

Error refuse(const std::string& what, const std::string& value, const std::string& range) {
  return content_error(what + " is " + value + ", must be " + range);
}

Status check_orthotropic(const OrthotropicElasticity& elasticity) {
  for (int i = 0; i < 3; ++i) {
    if (!is_positive(elasticity.young[i]))
      return refuse(kYoung[i], number_text(elasticity.young[i]), "positive and finite (Pa)");
    if (!is_positive(elasticity.shear[i]))
      return refuse(kShear[i], number_text(elasticity.shear[i]), "positive and finite (Pa)");
  }
  // The upper left block of the compliance, scaled to a unit diagonal, has -nu_ij sqrt(E_j / E_i)
  // next to it: its minors are requested.
  double determinant = 1.0 - 2.0 * elasticity.poisson.prod();
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const double ratio = elasticity.young[j] / elasticity.young[i];
    const double squared = elasticity.poisson[i] * elasticity.poisson[i] * ratio;
    if (!(squared < 1.0))
      return refuse(kPoisson[i], number_text(elasticity.poisson[i]),
                    "below sqrt(" + std::string(kYoung[i]) + "/" + kYoung[j] +
                        ") = " + number_text(std::sqrt(1.0 / ratio)) +
                        " in magnitude, or the energy is not positive");
    determinant -= squared;
  }
  if (!(determinant > 0.0))
    return refuse("1 - nu12^2 E2/E1 - nu23^2 E3/E2 - nu31^2 E1/E3 - 2 nu12 nu23 nu31",
                  number_text(determinant),
                  "positive: nu12, nu23 and nu31 are too large together, the energy of the "
                  "orthotropic material is not positive");
  const double skew = (elasticity.axes.transpose() * elasticity.axes - Eigen::Matrix3d::Identity())
                          .cwiseAbs()
                          .maxCoeff();
  constexpr double kDigits = 1e-9;  // material_axes() leaves 1e-15
  if (!(skew <= kDigits)) return content_error("the three axes are not orthonormal");
  return Success{};
}

}  // namespace

Status check_material(const Material& material) {
  if (!is_positive(material.density))
    return refuse("the density", number_text(material.density), "positive and finite (kg/m^3)");
  if (material.orthotropic) return check_orthotropic(*material.orthotropic);
  if (!is_positive(material.young))
    return refuse("Young's modulus", number_text(material.young), "positive and finite (Pa)");
  if (!(material.poisson > -1.0 && material.poisson < 0.5))
    return refuse("Poisson's ratio", number_text(material.poisson), "above -1 and below 0.5");
  return Success{};
}

Result<Eigen::Matrix3d> material_axes(const Eigen::Vector3d& first, const Eigen::Vector3d& second) {
  const auto text = [](const Eigen::Vector3d& v) {
    return number_text(v.x()) + " " + number_text(v.y()) + " " + number_text(v.z());
  };
  for (const Eigen::Vector3d& v : {first, second})
    if (!v.allFinite() || !is_positive(v.norm()))
      return content_error("the direction " + text(v) + " must be finite and other than zero");
  Eigen::Matrix3d axes;
  axes.col(0) = first.normalized();
  const Eigen::Vector3d unit = second.normalized();
  const Eigen::Vector3d rest = unit - axes.col(0) * axes.col(0).dot(unit);
  constexpr double kParallel = 1e-6;  // closer, the third direction would be rounding
  if (rest.norm() < kParallel)
    return content_error("the directions " + text(first) + " and " + text(second) +
                         " must not be parallel");
  axes.col(1) = (rest - axes.col(0) * axes.col(0).dot(rest)).normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

Result<RayleighDamping> parse_damping_ratios(std::string_view text) {
  const auto wrong = [&] {
    return usage_error("damping ratios " + std::string(text) +
                       ": expected F1:Z1,F2:Z2, two frequencies in Hz and the ratio at each, as in "
                       "1:0.02,30:0.05; a ratio of each mode is known to `tremolo response` only");
  };
  if (text.find(':') == std::string_view::npos) return wrong();
  const Result<DampingRatios> ratios = parse_damping(text);
  if (!ratios) return ratios.error().kind == ErrorKind::kUsage ? wrong() : ratios.error();
  return ratios->of_each_mode() ? Result<RayleighDamping>(wrong()) : ratios->rayleigh;
}

Result<RayleighDamping> rayleigh_damping(double f1, double z1, double f2, double z2,
                                         std::string_view text) {
  const std::string shown = "damping ratios " + std::string(text) + ": ";
  for (const double f : {f1, f2})
    if (!(f > 0) || !std::isfinite(f))
      return content_error(shown + "a frequency must be positive and finite");
  if (f1 == f2) return content_error(shown + "two different frequencies are needed");
  for (const double z : {z1, z2})
    if (!(z >= 0) || !(z < 1))
      return content_error(shown + "a ratio is a fraction of critical damping, from 0 to below 1");
  const double w1 = 2 * std::numbers::pi * f1, w2 = 2 * std::numbers::pi * f2;
  const double determinant = w2 * w2 - w1 * w1;
  RayleighDamping damping{2 * w1 * w2 * (z1 * w2 - z2 * w1) / determinant,
                          2 * (z2 * w2 - z1 * w1) / determinant};
  // Rounding of ratios that need only one of the two.
  const double rounding = 1e-14 * (z1 + z2);
  if (damping.alpha < 0 && damping.alpha > -rounding * (w1 + w2)) damping.alpha = 0;
  if (damping.beta < 0 && damping.beta > -rounding / (w1 + w2)) damping.beta = 0;
  if (damping.alpha >= 0 && damping.beta >= 0) return damping;
  return content_error(shown + "the ratio at " + number_text(f2) + " Hz must be between " +
                       number_text(z1 * std::min(f1 / f2, f2 / f1)) + " and " +
                       number_text(z1 * std::max(f1 / f2, f2 / f1)) +
                       ": mass and stiffness damping, neither of them negative, give no other");
}

}  // namespace tremolo
