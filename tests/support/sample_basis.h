// A small nonlinear model whose energy is known in closed form, for tests.
//
//     V(q) = 1/2 sum_e (omega_e q_e + q^T B_e q)^2,   B_e symmetric, e = 1..r
//
// has the shape of a StVK energy: a sum of squares of quadratic strains, never negative, with a
// diagonal Hessian at rest, Lambda = diag(omega^2). strain_energy(), strain_force() and
// strain_damping_force() evaluate this form directly; sample_basis() expands it into the packed
// coefficients of a basis file.
#pragma once

#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include <Eigen/Core>

#include "common/packed_index.h"
#include "formats/basis/basis_data.h"

namespace tremolo::testing {

struct StrainModel {
  Eigen::VectorXd omega;           // r, rad/s, ascending
  std::vector<Eigen::MatrixXd> b;  // r matrices r x r, symmetric
};

// nonlinearity: size of B_e relative to omega_e; 0 is a linear model. blocks: coordinates below it
// and those at or above it do not couple (0: all couple).
inline StrainModel random_strain_model(const Eigen::VectorXd& omega, double nonlinearity,
                                       unsigned seed, Eigen::Index blocks = 0) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const Eigen::Index r = omega.size();
  StrainModel model{omega, {}};
  for (Eigen::Index e = 0; e < r; ++e) {
    Eigen::MatrixXd b(r, r);
    for (Eigen::Index j = 0; j < r; ++j)
      for (Eigen::Index i = 0; i <= j; ++i) {
        const bool apart = (i < blocks) != (j < blocks) || (i < blocks) != (e < blocks);
        b(i, j) = b(j, i) = apart ? 0.0 : nonlinearity * omega[e] * uniform(generator);
      }
    model.b.push_back(b);
  }
  return model;
}

inline double strain_energy(const StrainModel& model, const Eigen::VectorXd& q) {
  double energy = 0.0;
  for (Eigen::Index e = 0; e < q.size(); ++e) {
    const double strain = model.omega[e] * q[e] + q.dot(model.b[e] * q);
    energy += 0.5 * strain * strain;
  }
  return energy;
}

inline Eigen::VectorXd strain_force(const StrainModel& model, const Eigen::VectorXd& q) {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(q.size());
  for (Eigen::Index e = 0; e < q.size(); ++e) {
    const Eigen::VectorXd bq = model.b[e] * q;
    const double strain = model.omega[e] * q[e] + q.dot(bq);
    force += 2.0 * strain * bq;
    force[e] += strain * model.omega[e];
  }
  return force;
}

// C_ijk and Q_ijkl: the symmetric parts of sum_e omega_e q_e q^T B_e q and 1/2 sum_e (q^T B_e q)^2.
inline void expand_coefficients(const StrainModel& model, BasisData& data) {
  const std::size_t r = model.omega.size();
  const auto b = [&](std::size_t e, std::size_t i, std::size_t j) {
    return model.b[e](static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  };
  data.cubic.clear();
  data.quartic.clear();
  const auto omega = [&](std::size_t e) { return model.omega[e]; };
  for (std::size_t k = 0; k < r; ++k)
    for (std::size_t j = 0; j <= k; ++j)
      for (std::size_t i = 0; i <= j; ++i)
        data.cubic.push_back(
            (omega(i) * b(i, j, k) + omega(j) * b(j, i, k) + omega(k) * b(k, i, j)) / 3.0);
  for (std::size_t l = 0; l < r; ++l)
    for (std::size_t k = 0; k <= l; ++k)
      for (std::size_t j = 0; j <= k; ++j)
        for (std::size_t i = 0; i <= j; ++i) {
          double sum = 0.0;
          for (std::size_t e = 0; e < r; ++e)
            sum += b(e, i, j) * b(e, k, l) + b(e, i, k) * b(e, j, l) + b(e, i, l) * b(e, j, k);
          data.quartic.push_back(sum / 6.0);
        }
}

// G of V = 1/2 y^T G y: the sum of c c^T, c the coefficients of one strain in the strain terms.
inline std::vector<double> expand_strain_gram(const StrainModel& model) {
  const std::size_t r = model.omega.size();
  Eigen::MatrixXd strains = Eigen::MatrixXd::Zero(r, strain_terms(r));
  for (std::size_t e = 0; e < r; ++e) {
    const auto row = static_cast<Eigen::Index>(e);
    const auto at = [](std::size_t i) { return static_cast<Eigen::Index>(i); };
    strains(row, at(strain_index(e))) = model.omega[row];
    for (std::size_t j = 0; j < r; ++j)
      for (std::size_t i = 0; i <= j; ++i)
        strains(row, at(strain_index(i, j))) = (i == j ? 1.0 : 2.0) * model.b[e](at(i), at(j));
  }
  const Eigen::MatrixXd gram = strains.transpose() * strains;
  std::vector<double> packed;
  for (Eigen::Index b = 0; b < gram.cols(); ++b)
    for (Eigen::Index a = 0; a <= b; ++a) packed.push_back(gram(a, b));
  return packed;
}

// The force of damping by the strains' rates: sum_e grad(strain_e) (grad(strain_e) . v).
inline Eigen::VectorXd strain_damping_force(const StrainModel& model, const Eigen::VectorXd& q,
                                            const Eigen::VectorXd& v) {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(q.size());
  for (Eigen::Index e = 0; e < q.size(); ++e) {
    Eigen::VectorXd gradient = 2.0 * (model.b[e] * q);
    gradient[e] += model.omega[e];
    force += gradient.dot(v) * gradient;
  }
  return force;
}

// The model as a basis: seven vertices, of which 1 and 4 lie inside and 0 is fixed; a default load
// on vertex 3.
inline BasisData sample_basis(const StrainModel& model, unsigned seed = 7) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  const Eigen::Index r = model.omega.size();
  BasisData data;
  data.vertex_count = 7;
  data.tetrahedron_count = 4;
  data.linear_mode_count = static_cast<std::uint64_t>(r);
  data.fixed_vertex_count = 1;
  data.total_mass = 2.0;
  data.lambda = model.omega.cwiseAbs2();
  expand_coefficients(model, data);
  data.strain_gram = expand_strain_gram(model);
  const auto fill = [&](VertexBlock& block, std::vector<VertexId> ids) {
    block.vertex_ids = std::move(ids);
    block.rows.resize(3 * block.vertex_ids.size(), r);
    for (double& value : block.rows.reshaped<Eigen::RowMajor>()) value = normal(generator);
    for (std::size_t v = 0; v < block.vertex_ids.size(); ++v)
      block.rest.emplace_back(normal(generator), normal(generator), normal(generator));
  };
  fill(data.surface, {0, 2, 3, 5, 6});
  fill(data.interior, {1, 4});
  data.surface.rows.topRows(3).setZero();
  data.triangles = {{0, 1, 2}, {0, 3, 4}, {1, 2, 3}};
  data.fixed_vertices = {0};
  data.load.vertices = {3};
  data.load.forces = {{0.0, 0.0, -2.0}};
  data.provenance = "{}";
  return data;
}

// Circular frequencies from `lowest` to `highest`, rad/s, geometrically spaced.
inline Eigen::VectorXd spread_omega(Eigen::Index r, double lowest, double highest) {
  Eigen::VectorXd omega(r);
  for (Eigen::Index i = 0; i < r; ++i)
    omega[i] =
        lowest * std::pow(highest / lowest,
                          r == 1 ? 0.0 : static_cast<double>(i) / static_cast<double>(r - 1));
  return omega;
}

inline Eigen::VectorXd random_vector(Eigen::Index size, double scale, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-scale, scale);
  Eigen::VectorXd vector(size);
  for (double& value : vector) value = uniform(generator);
  return vector;
}

}  // namespace tremolo::testing
