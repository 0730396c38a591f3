// The displayed stress of a body: of a triangle of its free surface, from the triangle's stretch
// alone.
//
//     F = [x1 - x0, x2 - x0] [X1 - X0, X2 - X0]^-1 (3 x 2, X in the triangle's plane),
//     C = F^T F,  E = (C - 1)/2,  S = Y/(1 - nu^2) ((1 - nu) E + nu tr(E) 1),
//     sigma = F S F^T / J,  J = sqrt(det C (1 + 2 E33)),  E33 = -nu/(1 - nu) tr(E)
//
// No force acts on a free surface, so that the stress normal to it is zero, S33 = 0 (plane stress).
// S and E33 follow from it (St. Venant-Kirchhoff, Young's modulus Y, Poisson's ratio nu). The
// result is von Mises' stress, sqrt(3/2 dev(sigma) : dev(sigma)), Pa. It is not valid where a force
// acts on the surface: at constraints, loads and contacts.
//
// A stress below kLeastStress of Young's modulus, or below the one that the rounding of positions
// to single precision makes (kRounding times the largest coordinate over the triangle's height), is
// not told from zero: a body with no larger one counts as unloaded.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "common/material.h"
#include "common/mesh/tet_mesh.h"

namespace tremolo {

inline constexpr float kLeastStress = 1e-6f;  // of Young's modulus
inline constexpr float kRounding = 2.4e-7f;   // 2^-22: of two positions, and their difference

class SurfaceStress {
 public:
  SurfaceStress() = default;
  // rest: s, m. Triangles without area have no stress.
  SurfaceStress(const std::vector<Eigen::Vector3d>& rest, std::span<const Triangle> triangles,
                const Material& material);
  // The same with a material for each triangle; none: it has no stress.
  SurfaceStress(const std::vector<Eigen::Vector3d>& rest, std::span<const Triangle> triangles,
                std::span<const std::optional<Material>> materials);

  bool empty() const { return patches_.empty(); }  // no triangle has a stress

  // positions: x y z ... of the s vertices, m. out: s numbers, Pa: for each vertex the mean of its
  // triangles, weighted by their area at rest; all zero for an unloaded body. Returns the largest.
  // If a surface is stretched so far that the material's thickness would vanish (tr E near (1 -
  // nu)/(2 nu)), a tenth of the thickness is kept.
  float look(std::span<const float> positions, std::vector<float>& out) const;

 private:
  struct StressPatch {
    Triangle corners;
    Eigen::Matrix2f inverse;
    float area = 0.0f, height = 0.0f;    // m^2, m: the least, at rest
    float young = 0.0f, poisson = 0.0f;  // Pa
  };
  void add(const std::vector<Eigen::Vector3d>& rest, const Triangle& triangle,
           const Material& material);
  float of_patch(const StressPatch& patch, std::span<const float> positions) const;

  std::size_t vertices_ = 0;
  std::vector<StressPatch> patches_;
  std::vector<float> area_;  // of each vertex's triangles, m^2
};

// The one isotropic material of a model, from a basis file's provenance (JSON, which is not
// trusted). None: there are several, it is orthotropic, or the file does not say.
std::optional<Material> material_of_provenance(std::string_view provenance);

// The same of a basis file; none where it cannot be read.
std::optional<Material> material_of_model(const std::string& path);

}  // namespace tremolo
