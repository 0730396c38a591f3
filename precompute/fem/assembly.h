// Element matrices, assembled through a callable, so that no sparse matrix type is named here.
#pragma once

#include "precompute/fem/dof_map.h"
#include "precompute/fem/stvk.h"

namespace tremolo {

// The choice of mass matrix, used from the elements to the file; mixing both loses
// M-orthonormality.
enum class MassKind { kConsistent, kLumped };

// Returns the mass of the pair (a, b) of an element's nodes, kg: rho times the integral of the
// product of their polynomials, or for order 1 lumped rho V/4 delta_ab. Order 2 has no lumped mass.
inline double element_mass(const Solid& solid, std::size_t element, int a, int b, MassKind kind) {
  const double mass = solid.density(element) * solid.elements[element].volume;
  if (kind == MassKind::kLumped) return a == b ? mass / 4.0 : 0.0;
  if (solid.order() == 1) return a == b ? mass / 10.0 : mass / 20.0;
  return mass * mass_share(2, a, b);
}

// Calls add(row node, column node, 3x3 block) for every pair of free nodes of every element in
// which this rank owns a node; row nodes are always owned by this rank. solid: this rank's part of
// the mesh.
template <class Add>
void for_each_stiffness_block(const Solid& solid, const LocalDofs& local, const Add& add) {
  for (int element : local.elements) {
    const std::size_t e = element;
    const ElementNodes nodes = element_nodes(solid.mesh, e);
    const ElementStiffness stiffness = rest_stiffness(solid, e);
    for (int a = 0; a < nodes.count; ++a) {
      if (local.row_of_vertex[nodes[a]] < 0) continue;
      for (int b = 0; b < nodes.count; ++b)
        if (local.node_of_vertex[nodes[b]] >= 0)
          add(local.node_of_vertex[nodes[a]], local.node_of_vertex[nodes[b]],
              Eigen::Matrix3d(stiffness.block<3, 3>(3 * a, 3 * b)));
    }
  }
}

// Does the same for the mass, point masses included, with add(row node, column node, value); the
// block is value times the identity.
template <class Add>
void for_each_mass_entry(const Solid& solid, const LocalDofs& local, MassKind kind,
                         const Add& add) {
  for (int element : local.elements) {
    const std::size_t e = element;
    const ElementNodes nodes = element_nodes(solid.mesh, e);
    for (int a = 0; a < nodes.count; ++a) {
      if (local.row_of_vertex[nodes[a]] < 0) continue;
      for (int b = 0; b < nodes.count; ++b) {
        if (local.node_of_vertex[nodes[b]] < 0 || (kind == MassKind::kLumped && a != b)) continue;
        add(local.node_of_vertex[nodes[a]], local.node_of_vertex[nodes[b]],
            element_mass(solid, e, a, b, kind));
      }
    }
  }
  for (std::size_t v = 0; v < solid.point_mass.size(); ++v)
    if (solid.point_mass[v] != 0 && local.row_of_vertex[v] >= 0)
      add(local.node_of_vertex[v], local.node_of_vertex[v], solid.point_mass[v]);
}

// Returns the mass of the whole mesh, point masses included, kg.
double total_mass(const Solid& solid);

}  // namespace tremolo
