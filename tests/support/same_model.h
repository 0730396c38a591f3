// Compares two basis files of one mesh as subspaces with frequencies, energies and forces.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>

#include "common/energy.h"
#include "common/mesh/tet_mesh.h"
#include "formats/basis/basis_data.h"

namespace tremolo::testing {

// All rows, in the order of the mesh's vertices.
inline BasisRows rows_of_file(const BasisData& data) {
  BasisRows rows =
      BasisRows::Zero(3 * static_cast<Eigen::Index>(data.vertex_count), data.lambda.size());
  for (const VertexBlock* block : {&data.surface, &data.interior})
    for (std::size_t i = 0; i < block->vertex_ids.size(); ++i)
      rows.middleRows<3>(3 * Eigen::Index{block->vertex_ids[i]}) =
          block->rows.middleRows<3>(3 * static_cast<Eigen::Index>(i));
  return rows;
}

// M X for the consistent mass of a mesh of one density.
inline BasisRows times_consistent_mass(const TetMesh& mesh, double density, const BasisRows& x) {
  BasisRows product = BasisRows::Zero(x.rows(), x.cols());
  for (const Tetrahedron& tet : mesh.tetrahedra) {
    const double share = density * signed_volume(mesh, tet) / 20.0;
    BasisRows sum = BasisRows::Zero(3, x.cols());
    for (const VertexId v : tet) sum += x.middleRows<3>(3 * Eigen::Index{v});
    for (const VertexId v : tet)
      product.middleRows<3>(3 * Eigen::Index{v}) +=
          share * (sum + x.middleRows<3>(3 * Eigen::Index{v}));
  }
  return product;
}

// All relative. subspace: largest M-norm of what of b's columns lies outside a's span, and of a's
// outside b's. energy, force: at displacements in a's span whose largest vertex moves by a tenth of
// the size; the forces as covectors on the displacements, brought to a's coordinates.
struct ModelDifference {
  double frequency = 0, subspace = 0, energy = 0, force = 0;
  double largest() const { return std::max({frequency, subspace, energy, force}); }
};
inline ModelDifference difference(const BasisData& a, const BasisData& b, const TetMesh& mesh,
                                  double density) {
  ModelDifference result;
  result.frequency =
      ((a.lambda.cwiseSqrt() - b.lambda.cwiseSqrt()).array() / a.lambda.cwiseSqrt().array())
          .abs()
          .maxCoeff();
  const BasisRows ua = rows_of_file(a), ub = rows_of_file(b);
  const BasisRows mb = times_consistent_mass(mesh, density, ub);
  const Eigen::MatrixXd change = ub.transpose() * times_consistent_mass(mesh, density, ua);
  const auto norm = [&](const BasisRows& x) {
    return std::sqrt(
        x.cwiseProduct(times_consistent_mass(mesh, density, x)).colwise().sum().maxCoeff());
  };
  result.subspace = std::max(norm(ua - ub * change), norm(ub - ua * change.transpose()));
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const double reach = 0.1 * bounding_box(mesh.vertices).diagonal();
  for (int sample = 0; sample < 5; ++sample) {
    Eigen::VectorXd q(a.lambda.size());
    for (Eigen::Index i = 0; i < q.size(); ++i) q[i] = uniform(engine) / std::sqrt(a.lambda[i]);
    const Eigen::VectorXd u = ua * q;
    double moved = 0;
    for (Eigen::Index v = 0; v < u.size(); v += 3) moved = std::max(moved, u.segment<3>(v).norm());
    q *= reach / moved;
    const EnergyAndForce first = reduced_energy(a.lambda, a.cubic, a.quartic, q),
                         second = reduced_energy(b.lambda, b.cubic, b.quartic, change * q);
    result.energy = std::max(result.energy, std::abs(first.energy - second.energy) / first.energy);
    result.force = std::max(result.force, (first.force - change.transpose() * second.force).norm() /
                                              first.force.norm());
  }
  return result;
}

}  // namespace tremolo::testing
