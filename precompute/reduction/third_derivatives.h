// Third derivatives of the static equilibrium along the softest modes.
//
// Under loads M Psi p the body is at u(p) = sum Psi_i p_i + 1/2 sum Phi_ij p_i p_j + 1/6 sum Xi_ijl
// p_i p_j p_l + ... . Collecting third orders of K u + 1/2 H[u, u] + 1/6 C[u, u, u] gives
//   K Xi_ijl = -(H[Psi_i, Phi_jl] + H[Psi_j, Phi_il] + H[Psi_l, Phi_ij] + C[Psi_i, Psi_j, Psi_l]).
// If a body bends by several thicknesses, its parts rotate by angles whose cube the second order
// leaves out: a basis without the third order is too stiff there, with any number of modes.
#pragma once

#include <array>
#include <vector>

#include "precompute/fem/dof_map.h"
#include "precompute/reduction/derivatives.h"

namespace tremolo {

// i <= j <= l with i, j < leading and l < modes, l the slowest: (0, 0, l) for one leading mode.
std::vector<std::array<int, 3>> third_orders(Eigen::Index modes, int leading);

// The same for a matrix of that many columns: modes, derivatives, and those of third order if it
// has any.
std::vector<std::array<int, 3>> third_orders_of(Eigen::Index modes, Eigen::Index columns);

// Returns how many modes are as soft as the first: omega^2 at most 5 % above the lowest,
// three at most. Of those that a symmetric body has twice none is preferred.
int leading_modes(const Eigen::VectorXd& squared_frequencies);

// The body whose derivatives are solved for, its unknowns, and the factor. solver: prepared.
struct BodyAtRest {
  const Solid& solid;
  const DofMap& map;
  const LocalDofs& local;
  const Pencil& pencil;
  const ShiftedSolver& solver;
};

// Appends Xi_ijl for third_orders(k, leading) to the columns. psi: the modes at all vertices, 3n x
// k. Throws Failure as solve_at_rest. Collective.
void add_third_derivatives(const BodyAtRest& body, const BasisRows& psi, int leading,
                           ModalDerivatives& derivatives);

}  // namespace tremolo
