// Materials in the form that element loops use (docs/theory.md, section "Elements").
//
// In Mandel's notation a strain is e = (E_xx, E_yy, E_zz, r2 E_yz, r2 E_xz, r2 E_xy), r2 = sqrt(2),
// and a stress s has the same form: S:E is a scalar product, a rotation of the axes is an
// orthogonal 6x6 matrix, and S = C E is s = C e with C symmetric and positive definite.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/material.h"

namespace tremolo {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

// tensor: C in the mesh's frame, Pa. root: upper triangular, root^T root = C. lambda, mu: Lame's
// constants of an isotropic material, Pa; 0 for others.
struct Elasticity {
  bool isotropic = true;
  double lambda = 0;
  double mu = 0;
  Matrix6 tensor = Matrix6::Zero();
  Matrix6 root = Matrix6::Zero();
};

// Requires a material that has passed check_material.
Elasticity make_elasticity(const Material& material);

// Returns the orthogonal matrix that maps strains from the frame of `axes` (columns) to the mesh's.
Matrix6 mandel_rotation(const Eigen::Matrix3d& axes);

// Returns S = C E, Pa, for a symmetric strain E.
Eigen::Matrix3d stress(const Elasticity& elasticity, const Eigen::Matrix3d& strain);

// A material and its label for the user: a region's name, a selector or "default".
struct NamedMaterial {
  std::string name;
  Material material;
};

// materials: at least one. of_tet: index into them for each tetrahedron; empty: index 0 for all.
struct MaterialTable {
  std::vector<NamedMaterial> materials;
  std::vector<std::int32_t> of_tet;

  const Material& of(std::size_t tetrahedron) const {
    return materials[of_tet.empty() ? 0 : of_tet[tetrahedron]].material;
  }
};

}  // namespace tremolo
