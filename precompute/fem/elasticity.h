// Materials as element loops want them (docs/theory.md, section "Elements").
//
// In Mandel's notation a strain is e = (E_xx, E_yy, E_zz, r2 E_yz, r2 E_xz, r2 E_xy), r2 = sqrt(2),
// a stress alike: S:E is a scalar product, a rotation of the axes is an orthogonal 6x6 matrix, and
// S = C E is s = C e with C symmetric and positive definite.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/material.h"

namespace tremolo {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

// tensor: C in the mesh's frame, Pa. root: upper triangular, root^T root = C. lambda, mu: of an
// isotropic material, Pa.
struct Elasticity {
  bool isotropic = true;
  double lambda = 0;
  double mu = 0;
  Matrix6 tensor = Matrix6::Zero();
  Matrix6 root = Matrix6::Zero();
};

// The material must have passed check_material.
Elasticity make_elasticity(const Material& material);

// The orthogonal matrix that takes strains in the frame of `axes` (its columns) to the mesh's.
Matrix6 mandel_rotation(const Eigen::Matrix3d& axes);

Eigen::Matrix3d stress(const Elasticity& elasticity, const Eigen::Matrix3d& strain);

// A material and what it is of, for the user: a region's name, a selector, "default".
struct NamedMaterial {
  std::string name;
  Material material;
};

// materials: at least one. of_tet: an index into them for each tetrahedron; empty: all the first.
struct MaterialTable {
  std::vector<NamedMaterial> materials;
  std::vector<std::int32_t> of_tet;

  const Material& of(std::size_t tetrahedron) const {
    return materials[of_tet.empty() ? 0 : static_cast<std::size_t>(of_tet[tetrahedron])].material;
  }
};

}  // namespace tremolo
