// Derivatives of squared frequencies with respect to the constants of each material.
//
// For K psi = omega^2 M psi with psi^T M psi = 1,
//
//     d omega^2 = psi^T (dK - omega^2 dM) psi.
//
// K is linear in Lame's constants of each material, M in its density, so that integrals over a
// material's elements give all derivatives. Several modes of one frequency have the eigenvalues of
// this expression on the space that they span.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "formats/basis/basis_data.h"
#include "precompute/fem/assembly.h"
#include "precompute/modes/mode_clusters.h"

namespace tremolo {

// Integrals over the elements of one material, k x k each, symmetric, over the k modes.
struct ModalForms {
  Eigen::MatrixXd stiffness;  // Psi^T K_m Psi, (rad/s)^2
  Eigen::MatrixXd poisson;    // Psi^T dK_m/dnu Psi, (rad/s)^2; zeros of an orthotropic material
  Eigen::MatrixXd mass;       // Psi^T M_m Psi
};

// One entry a material. psi: the modes at the vertices of this rank's part, 3n x k, control values.
// count: the elements of the part that count here, the first ones. Collective.
std::vector<ModalForms> modal_forms(const Solid& solid, std::size_t count, const BasisRows& psi,
                                    MassKind kind);

// Derivatives of omega^2 of k modes with respect to the constants of one material, (rad/s)^2 each:
// to the logarithm of its stiffness (E, or all moduli of an orthotropic material together), to
// Poisson's ratio, and to the logarithm of its density.
struct ModeDerivatives {
  Eigen::VectorXd by_log_stiffness;
  Eigen::VectorXd by_poisson;
  Eigen::VectorXd by_log_density;
};

// squared: omega^2 of the modes, k, ascending. Within a cluster the values are the eigenvalues on
// its space, ascending: each constant splits the cluster in its own way.
ModeDerivatives mode_derivatives(const ModalForms& forms, const Eigen::VectorXd& squared,
                                 const std::vector<Cluster>& clusters);

}  // namespace tremolo
