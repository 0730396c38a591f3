#include "precompute/reduction/inertia.h"

#include "common/packed_index.h"
#include "precompute/dense/blas.h"
#include "precompute/system/petsc.h"

namespace tremolo {
namespace {

using Eigen::Index;

// Rows of the basis as one row a vertex: x of all r columns, then y, then z.
using PerVertex = Eigen::Map<const BasisRows>;

PerVertex per_vertex(const BasisRows& basis) {
  return {basis.data(), basis.rows() / 3, 3 * basis.cols()};
}

// Returns M U: one row a vertex, n x 3r, of the elements and point masses that count here.
BasisRows mass_times(const Solid& solid, std::size_t count, const LocalDofs& local,
                     const BasisRows& basis, MassKind kind) {
  const PerVertex u = per_vertex(basis);
  BasisRows product = BasisRows::Zero(u.rows(), u.cols());
  for (std::size_t e = 0; e < count; ++e) {
    const ElementNodes nodes = element_nodes(solid.mesh, e);
    for (int a = 0; a < nodes.count; ++a)
      for (int b = 0; b < nodes.count; ++b)
        if (const double mass = element_mass(solid, e, a, b, kind); mass != 0)
          product.row(nodes[a]) += mass * u.row(nodes[b]);
  }
  for (std::size_t v = 0; v < solid.point_mass.size(); ++v)
    if (solid.point_mass[v] != 0 && local.row_of_vertex[v] >= 0) {
      const Index row = v;
      product.row(row) += solid.point_mass[v] * u.row(row);
    }
  return product;
}

}  // namespace

InertiaIntegrals basis_inertia(const Solid& solid, std::size_t count, const LocalDofs& local,
                               const BasisRows& basis, MassKind kind) {
  const Index r = basis.cols(), n = basis.rows() / 3;
  const BasisRows mass_u = mass_times(solid, count, local, basis, kind);
  // Ones and the rest positions beside U: the transposed product then holds all integrals.
  Eigen::MatrixXd left(n, 4 + 3 * r);
  left.col(0).setOnes();
  for (Index v = 0; v < n; ++v) left.block<1, 3>(v, 1) = solid.mesh.vertices[v].transpose();
  left.rightCols(3 * r) = per_vertex(basis);
  Eigen::MatrixXd sums = transposed_product(left, Eigen::MatrixXd(mass_u));
  sum_over_ranks(sums);

  InertiaIntegrals inertia;
  inertia.linear.resize(12, r);
  inertia.B.resize(9, pair_count(static_cast<std::size_t>(r)));
  for (Index l = 0; l < 3; ++l) {
    inertia.linear.row(l) = sums.block(0, l * r, 1, r);
    for (Index k = 0; k < 3; ++k) {
      inertia.linear.row(3 + 3 * k + l) = sums.block(1 + k, l * r, 1, r);
      for (Index j = 0; j < r; ++j)
        for (Index i = 0; i <= j; ++i) {
          const auto pair = pair_index(static_cast<std::size_t>(i), static_cast<std::size_t>(j));
          inertia.B(3 * k + l, static_cast<Index>(pair)) = sums(4 + k * r + i, l * r + j);
        }
    }
  }
  return inertia;
}

void add_rest_moments(const Solid& whole, MassKind kind, InertiaIntegrals& inertia) {
  inertia.mass = 0;
  inertia.first_moment.setZero();
  inertia.second_moment.setZero();
  const auto add = [&](const Eigen::Vector3d& x, const Eigen::Vector3d& y, double mass) {
    inertia.mass += mass;
    inertia.first_moment += mass * x;
    inertia.second_moment += mass * x * y.transpose();
  };
  const std::vector<Eigen::Vector3d>& rest = whole.mesh.vertices;
  for (std::size_t e = 0; e < whole.elements.size(); ++e) {
    const ElementNodes nodes = element_nodes(whole.mesh, e);
    for (int a = 0; a < nodes.count; ++a)
      for (int b = 0; b < nodes.count; ++b)
        add(rest[nodes[a]], rest[nodes[b]], element_mass(whole, e, a, b, kind));
  }
  for (std::size_t v = 0; v < whole.point_mass.size(); ++v)
    add(rest[v], rest[v], whole.point_mass[v]);
}

}  // namespace tremolo
