// Small models that can be fixed to a moving frame or free: clouds of mass points whose basis
// is orthonormal in their masses, so that all integrals belong to one body.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <random>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "common/packed_index.h"
#include "runtime/contact_body.h"
#include "runtime/model.h"
#include "tests/support/dynamics.h"
#include "tests/support/sample_basis.h"

namespace tremolo::testing {

// masses: kg. places: m. basis: 3n x r, kg^-1/2; the fields of point k are rows 3k to 3k + 2.
struct PointCloud {
  std::vector<double> masses;
  std::vector<Eigen::Vector3d> places;
  Eigen::MatrixXd basis;
};

// The rigid motions of the cloud about its centre, 3n x 6, orthonormal in its masses.
inline Eigen::MatrixXd rigid_fields(const PointCloud& cloud) {
  const Eigen::Index n = cloud.masses.size();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double mass = 0.0;
  for (std::size_t k = 0; k < cloud.masses.size(); ++k) {
    centre += cloud.masses[k] * cloud.places[k];
    mass += cloud.masses[k];
  }
  centre /= mass;
  Eigen::MatrixXd fields(3 * n, 6);
  for (Eigen::Index k = 0; k < n; ++k)
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d e = Eigen::Vector3d::Unit(axis);
      const Eigen::Vector3d arm = cloud.places[k] - centre;
      fields.block<3, 1>(3 * k, axis) = e;
      fields.block<3, 1>(3 * k, 3 + axis) = e.cross(arm);
    }
  return fields;
}

// Gram and Schmidt, twice, in the masses: the columns of `fields` after the first `given`, which
// are orthonormalised too.
inline Eigen::MatrixXd mass_orthonormal(Eigen::MatrixXd fields, const std::vector<double>& masses) {
  Eigen::VectorXd weights(fields.rows());
  for (Eigen::Index row = 0; row < fields.rows(); ++row) weights[row] = masses[row / 3];
  for (Eigen::Index j = 0; j < fields.cols(); ++j) {
    for (int pass = 0; pass < 2; ++pass)
      for (Eigen::Index i = 0; i < j; ++i)
        fields.col(j) -= fields.col(i).dot(weights.cwiseProduct(fields.col(j))) * fields.col(i);
    fields.col(j) /= std::sqrt(fields.col(j).dot(weights.cwiseProduct(fields.col(j))));
  }
  return fields;
}

// Points in a box of unequal edges, m, some kilograms together. free: the basis leaves rigid
// motions out; else the first point does not move.
inline PointCloud random_cloud(Eigen::Index modes, bool free, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  PointCloud cloud;
  constexpr Eigen::Index kPoints = 12;
  for (Eigen::Index k = 0; k < kPoints; ++k) {
    cloud.masses.push_back(0.2 + 0.1 * uniform(generator));
    cloud.places.emplace_back(0.5 * uniform(generator), 0.3 * uniform(generator),
                              0.15 * uniform(generator) + 0.1);
  }
  Eigen::MatrixXd fields(3 * kPoints, modes);
  for (double& value : fields.reshaped()) value = uniform(generator);
  if (free) {
    Eigen::MatrixXd all(3 * kPoints, 6 + modes);
    all << rigid_fields(cloud), fields;
    cloud.basis = mass_orthonormal(std::move(all), cloud.masses).rightCols(modes);
  } else {
    fields.topRows<3>().setZero();
    cloud.basis = mass_orthonormal(std::move(fields), cloud.masses);
  }
  return cloud;
}

inline InertiaIntegrals integrals_of(const PointCloud& cloud) {
  const Eigen::Index r = cloud.basis.cols();
  InertiaIntegrals integrals;
  integrals.first_moment.setZero();
  integrals.second_moment.setZero();
  integrals.linear.setZero(12, r);
  integrals.B.setZero(9, pair_count(static_cast<std::size_t>(r)));
  for (std::size_t k = 0; k < cloud.masses.size(); ++k) {
    const double m = cloud.masses[k];
    const Eigen::Vector3d& X = cloud.places[k];
    const Eigen::MatrixXd phi = cloud.basis.middleRows(3 * static_cast<Eigen::Index>(k), 3);
    integrals.mass += m;
    integrals.first_moment += m * X;
    integrals.second_moment += m * X * X.transpose();
    for (Eigen::Index j = 0; j < r; ++j) {
      integrals.linear.col(j).head<3>() += m * phi.col(j);
      for (Eigen::Index a = 0; a < 3; ++a)
        for (Eigen::Index b = 0; b < 3; ++b) {
          integrals.linear(3 + 3 * a + b, j) += m * X[a] * phi(b, j);
          for (Eigen::Index i = 0; i <= j; ++i)
            integrals.B(3 * a + b,
                        static_cast<Eigen::Index>(pair_index(static_cast<std::size_t>(i),
                                                             static_cast<std::size_t>(j)))) +=
                m * phi(a, i) * phi(b, j);
        }
    }
  }
  return integrals;
}

// All points are on the surface; the energy is that of a strain model of as many coordinates.
inline BasisData basis_of(const PointCloud& cloud, const StrainModel& strain, bool free) {
  BasisData data;
  const std::size_t n = cloud.masses.size();
  data.vertex_count = n;
  data.tetrahedron_count = 1;
  data.linear_mode_count = static_cast<std::uint64_t>(cloud.basis.cols());
  data.rigid_mode_count = free ? 6 : 0;
  data.lambda = strain.omega.cwiseAbs2();
  expand_coefficients(strain, data);
  data.strain_gram = expand_strain_gram(strain);
  for (std::size_t k = 0; k < n; ++k) data.surface.vertex_ids.push_back(static_cast<VertexId>(k));
  data.surface.rest = cloud.places;
  data.surface.rows = cloud.basis;
  data.interior.rows.resize(0, cloud.basis.cols());
  data.triangles = {{0, 1, 2}, {3, 4, 5}};
  data.inertia = integrals_of(cloud);
  data.total_mass = data.inertia->mass;
  if (!free) {
    data.fixed_vertex_count = 1;
    data.fixed_vertices = {0};
  }
  data.load.vertices = {5};
  data.load.forces = {{0.4, -0.3, 0.8}};
  data.provenance = "{}";
  return data;
}

// A model of `modes` coordinates between the given frequencies, rad/s. nonlinearity: as in
// random_strain_model.
inline Model::Pointer frame_model(Eigen::Index modes, bool free, double lowest, double highest,
                                  double nonlinearity = 0.2, unsigned seed = 3) {
  const StrainModel strain =
      random_strain_model(spread_omega(modes, lowest, highest), nonlinearity, seed);
  Result<Model::Pointer> model =
      Model::from_data(basis_of(random_cloud(modes, free, seed), strain, free));
  EXPECT_TRUE(model) << (model ? "" : model.error().message);
  return *model;
}

inline ContactBody make_framed(const Model::Pointer& model, FrameKind kind,
                               const IntegratorOptions& options, std::string_view method = "ep4") {
  Result<ContactBody> body = ContactBody::create(model, method, options, kind);
  EXPECT_TRUE(body) << (body ? "" : body.error().message);
  return std::move(*body);
}

// The classical method of Runge and Kutta from s over `time`: has no code in common with the tested
// method. slope(t, q, v): the rates of both.
template <class Slope>
State runge_kutta(State s, double time, int steps, const Slope& slope) {
  const double h = time / steps;
  for (int k = 0; k < steps; ++k) {
    const double t = k * h;
    const State k1 = slope(t, s.q, s.p);
    const State k2 = slope(t + 0.5 * h, s.q + 0.5 * h * k1.q, s.p + 0.5 * h * k1.p);
    const State k3 = slope(t + 0.5 * h, s.q + 0.5 * h * k2.q, s.p + 0.5 * h * k2.p);
    const State k4 = slope(t + h, s.q + h * k3.q, s.p + h * k3.p);
    s.q += h / 6.0 * (k1.q + 2.0 * k2.q + 2.0 * k3.q + k4.q);
    s.p += h / 6.0 * (k1.p + 2.0 * k2.p + 2.0 * k3.p + k4.p);
  }
  return s;
}

// Error of an energy balance: the largest energy, and the largest difference between energy, work
// and dissipation, J.
struct Balance {
  double most = 0.0, worst = 0.0;
};

// The energy balance of `count` steps that begin at rest; step(): makes one of the body's.
template <class Step>
Balance balance_of(ContactBody& body, int count, const Step& step) {
  Balance balance;
  for (int k = 0; k < count; ++k) {
    EXPECT_TRUE(step().converged) << k;
    const double energy = body.energy().total();
    balance.most = std::max(balance.most, energy);
    balance.worst =
        std::max(balance.worst, std::abs(energy - body.sums().work + body.sums().dissipated));
  }
  return balance;
}

// The balance closes to rounding although support and gravity did work.
inline void expect_balance(const Balance& balance, const ContactBody& body, const char* method) {
  std::printf("%s: balance %.1e of %.3g J\n", method, balance.worst / balance.most, balance.most);
  EXPECT_GT(std::abs(body.sums().support), 0.1 * balance.most) << method;
  EXPECT_GT(std::abs(body.sums().gravity), 1e-3 * balance.most) << method;
  EXPECT_LE(balance.worst, 1e-12 * balance.most) << method;
}

inline void steps_of(ContactBody& body, int count) {
  for (int k = 0; k < count; ++k) ASSERT_TRUE(body.step().converged) << k;
}

}  // namespace tremolo::testing
