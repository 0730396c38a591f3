// The integrals that couple a body to a moving frame, against sums over many points of mass.
#include "precompute/reduction/inertia.h"

#include <random>

#include <gtest/gtest.h>

#include "common/packed_index.h"
#include "precompute/fem/control_values.h"
#include "tests/support/assembled_body.h"
#include "tests/support/meshes/box_mesh.h"
#include "tests/support/meshes/mass_points.h"

namespace tremolo {
namespace {

using testing::AssembledBody;
using testing::MassPoint;

constexpr Eigen::Index kColumns = 4;

// An uneven box off the origin, of two materials, fixed at x = 0.1, with three point masses, of
// which one is on a fixed vertex.
struct TwoMaterialBox {
  MaterialTable table;
  TetMesh mesh;
  std::vector<VertexId> fixed;
  std::vector<double> point_mass;

  explicit TwoMaterialBox(int order) {
    table.materials = {{"light", {2e5, 0.3, 700.0}}, {"heavy", {9e5, 0.4, 2600.0}}};
    TetMesh box = testing::box_mesh({3, 2, 2}, {0.3, 0.2, 0.25});
    std::mt19937 engine(11);
    std::uniform_real_distribution<double> uniform(-0.01, 0.01);
    for (Eigen::Vector3d& x : box.vertices)
      x += Eigen::Vector3d(0.1 + (x.x() > 0 ? uniform(engine) : 0.0), -0.3 + uniform(engine),
                           0.2 + uniform(engine));
    fixed = testing::vertices_on_plane(box, 0, 0.1);
    mesh = testing::of_order(box, order);
    if (order == 2) {
      const std::vector<VertexId> held = held_edge_points(mesh, fixed, fixed);
      fixed.insert(fixed.end(), held.begin(), held.end());
      std::sort(fixed.begin(), fixed.end());
    }
    for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e)
      table.of_tet.push_back(e % 3 == 0 ? 1 : 0);
    point_mass.assign(mesh.vertices.size(), 0.0);
    point_mass[fixed.front()] = 0.3;
    point_mass[5] = 0.7;
    point_mass[17] = 1.1;
  }
  double density(std::size_t element) const { return table.of(element).density; }
};

// Displacements, zero at fixed vertices; 3n x kColumns.
BasisRows held_fields(const TwoMaterialBox& box) {
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  BasisRows fields(3 * static_cast<Eigen::Index>(box.mesh.vertices.size()), kColumns);
  for (double& value : fields.reshaped<Eigen::RowMajor>()) value = uniform(engine);
  for (VertexId v : box.fixed) fields.middleRows<3>(3 * Eigen::Index{v}).setZero();
  return fields;
}

// Expected results of basis_inertia() and add_rest_moments(), summed over points.
struct PointSums {
  InertiaIntegrals sums;

  PointSums() {
    sums.first_moment.setZero();
    sums.second_moment.setZero();
    sums.linear.setZero(12, kColumns);
    sums.B.setZero(9, pair_count(kColumns));
  }
  // fields: 3 x kColumns, at the point.
  void add(double mass, const Eigen::Vector3d& place, const Eigen::MatrixXd& fields) {
    sums.mass += mass;
    sums.first_moment += mass * place;
    sums.second_moment += mass * place * place.transpose();
    for (Eigen::Index j = 0; j < kColumns; ++j)
      for (Eigen::Index l = 0; l < 3; ++l) {
        sums.linear(l, j) += mass * fields(l, j);
        for (Eigen::Index k = 0; k < 3; ++k) {
          sums.linear(3 + 3 * k + l, j) += mass * place[k] * fields(l, j);
          for (Eigen::Index i = 0; i <= j; ++i)
            sums.B(3 * k + l, static_cast<Eigen::Index>(pair_index(static_cast<std::size_t>(i),
                                                                   static_cast<std::size_t>(j)))) +=
                mass * fields(k, i) * fields(l, j);
        }
      }
  }
};

PointSums integrate(const TwoMaterialBox& box, const BasisRows& fields) {
  PointSums sums;
  const auto density = [&](std::size_t e) { return box.density(e); };
  testing::for_each_mass_point(box.mesh, density, [&](const MassPoint& point) {
    Eigen::MatrixXd here = Eigen::MatrixXd::Zero(3, kColumns);
    for (int a = 0; a < point.nodes.count; ++a) {
      const std::size_t at = a;
      here += point.shape[at] * fields.middleRows<3>(3 * Eigen::Index{point.nodes[at]});
    }
    sums.add(point.mass, point.place, here);
  });
  return sums;
}

void add_point_masses(const TwoMaterialBox& box, const BasisRows& fields, PointSums& sums) {
  for (std::size_t v = 0; v < box.point_mass.size(); ++v)
    sums.add(box.point_mass[v], box.mesh.vertices[v],
             fields.middleRows<3>(3 * static_cast<Eigen::Index>(v)));
}

InertiaIntegrals computed(const TwoMaterialBox& box, const BasisRows& fields, MassKind kind) {
  const AssembledBody body(box.mesh, box.table, box.fixed, box.point_mass, MassKind::kConsistent);
  BasisRows control = fields;
  to_control_values(body.mesh, control);
  InertiaIntegrals inertia =
      basis_inertia(body.solid, body.local.counted, body.local, control, kind);
  add_rest_moments(body.solid, kind, inertia);
  return inertia;
}

// A few hundred elements are summed: rounding stays below 1e-13 of the largest entry.
void expect_equal(const InertiaIntegrals& a, const InertiaIntegrals& b) {
  constexpr double kFewRoundings = 1e-12;
  EXPECT_NEAR(a.mass, b.mass, kFewRoundings * b.mass);
  EXPECT_LE((a.first_moment - b.first_moment).norm(), kFewRoundings * b.first_moment.norm());
  EXPECT_LE((a.second_moment - b.second_moment).norm(), kFewRoundings * b.second_moment.norm());
  EXPECT_LE((a.linear - b.linear).norm(), kFewRoundings * b.linear.norm());
  EXPECT_LE((a.B - b.B).norm(), kFewRoundings * b.B.norm());
}

TEST(InertiaIntegralsOfAMesh, AreSumsOverItsMassForBothOrders) {
  for (const int order : {1, 2}) {
    const TwoMaterialBox box(order);
    const BasisRows fields = held_fields(box);
    PointSums sums = integrate(box, fields);
    // Compares the mesh's mass, so that the points themselves are right.
    double mass = 0;
    for (std::size_t e = 0; e < box.mesh.tetrahedra.size(); ++e)
      mass += box.density(e) * std::abs(signed_volume(box.mesh, box.mesh.tetrahedra[e]));
    EXPECT_NEAR(sums.sums.mass, mass, 1e-12 * mass);
    add_point_masses(box, fields, sums);
    expect_equal(computed(box, fields, MassKind::kConsistent), sums.sums);
  }
}

TEST(InertiaIntegralsOfAMesh, OfALumpedMassAreSumsOverVertices) {
  const TwoMaterialBox box(1);
  const BasisRows fields = held_fields(box);
  PointSums sums;
  for (std::size_t e = 0; e < box.mesh.tetrahedra.size(); ++e) {
    const double quarter =
        0.25 * box.density(e) * std::abs(signed_volume(box.mesh, box.mesh.tetrahedra[e]));
    for (VertexId v : box.mesh.tetrahedra[e])
      sums.add(quarter, box.mesh.vertices[v], fields.middleRows<3>(3 * Eigen::Index{v}));
  }
  add_point_masses(box, fields, sums);
  expect_equal(computed(box, fields, MassKind::kLumped), sums.sums);
}

}  // namespace
}  // namespace tremolo
