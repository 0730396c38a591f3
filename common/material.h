// A St. Venant-Kirchhoff material, isotropic or orthotropic.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "common/result.h"

namespace tremolo {

// Nine constants along three directions. Pulling along direction i shrinks direction j by nu_ij of
// the stretch, so nu_ij / E_i = nu_ji / E_j; G_ij is stress over twice the strain. axes: the
// columns are the three directions, orthonormal; a mirrored triple is the same material.
struct OrthotropicElasticity {
  Eigen::Vector3d young = Eigen::Vector3d::Zero();    // E1, E2, E3, Pa
  Eigen::Vector3d poisson = Eigen::Vector3d::Zero();  // nu12, nu23, nu31
  Eigen::Vector3d shear = Eigen::Vector3d::Zero();    // G12, G23, G31, Pa
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();

  bool operator==(const OrthotropicElasticity& other) const {
    return young == other.young && poisson == other.poisson && shear == other.shear &&
           axes == other.axes;
  }
};

// young: Pa; poisson: dimensionless; density: kg/m^3. With `orthotropic`, young and poisson are
// ignored.
struct Material {
  double young = 1e6;
  double poisson = 0.45;
  double density = 1000.0;
  std::optional<OrthotropicElasticity> orthotropic = std::nullopt;

  bool operator==(const Material& other) const = default;
};

// First and second Lame constants of an isotropic material, Pa.
inline double lame_lambda(const Material& material) {
  return material.young * material.poisson /
         ((1.0 + material.poisson) * (1.0 - 2.0 * material.poisson));
}
inline double lame_mu(const Material& material) {
  return material.young / (2.0 * (1.0 + material.poisson));
}

// The energy is positive exactly for E > 0 and -1 < nu < 1/2, of an orthotropic material for
// E_i, G_ij > 0, nu_ij^2 < E_i / E_j and
// 1 - nu12^2 E2/E1 - nu23^2 E3/E2 - nu31^2 E1/E3 - 2 nu12 nu23 nu31 > 0; the mass for rho > 0.
// Errors (kContent) name the constant and its range.
Status check_material(const Material& material);

// Columns: the unit vector along `first`, that along the part of `second` perpendicular to it, and
// their cross product. Errors (kContent): not finite, zero, or parallel.
Result<Eigen::Matrix3d> material_axes(const Eigen::Vector3d& first, const Eigen::Vector3d& second);

// Damping alpha M + beta K: a mode of frequency w has the ratio alpha / (2 w) + beta w / 2.
struct RayleighDamping {
  double alpha = 0.0;  // 1/s
  double beta = 0.0;   // s
};

}  // namespace tremolo
