// A bar of tetrahedra that can be attached to bones, and its mass as points, which gives the effect
// of the bones by other means.
#pragma once

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "runtime/bones.h"
#include "tests/support/frames/frame_models.h"
#include "tests/support/meshes/box_mesh.h"
#include "tests/support/meshes/mass_points.h"

namespace tremolo::testing {

// mesh: of the bar. cloud: its mass at Gauss points, with the fields there. elements: of each point
// the tetrahedron that it is in.
struct RiggedBar {
  TetMesh mesh;
  PointCloud cloud;
  std::vector<std::size_t> elements;
  StrainModel strain;
  BasisData data;
  Model::Pointer model;
};

inline constexpr double kBarDensity = 1300.0;  // kg/m^3

// `modes` smooth random fields on a bar along x of 0.6 m, orthonormal in its mass and zero at x =
// 0. order: of its elements. nonlinearity: as in random_strain_model.
inline RiggedBar rigged_bar(Eigen::Index modes, int order = 2, double nonlinearity = 0.2) {
  RiggedBar bar;
  bar.mesh = of_order(box_mesh({6, 2, 2}, {0.6, 0.1, 0.12}), order);
  std::mt19937 generator(11);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const Eigen::Index n = bar.mesh.vertices.size();
  Eigen::MatrixXd rows(3 * n, modes);
  for (Eigen::Index j = 0; j < modes; ++j) {
    Eigen::Matrix3d slope, bend;
    for (double& value : slope.reshaped()) value = uniform(generator);
    for (double& value : bend.reshaped()) value = uniform(generator);
    for (Eigen::Index v = 0; v < n; ++v) {
      const Eigen::Vector3d x = bar.mesh.vertices[v] / 0.6;
      const Eigen::Vector3d waves(std::sin(3.0 * x.x()), x.x() * x.x(), x.x() * x.y());
      rows.block<3, 1>(3 * v, j) = x.x() * (slope * x + bend * waves);
    }
  }
  for_each_mass_point(
      bar.mesh, [](std::size_t) { return kBarDensity; },
      [&](const MassPoint& point) {
        bar.cloud.masses.push_back(point.mass);
        bar.cloud.places.push_back(point.place);
        bar.elements.push_back(point.element);
      });
  Eigen::MatrixXd at_points =
      Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(bar.elements.size()), modes);
  Eigen::Index k = 0;
  for_each_mass_point(
      bar.mesh, [](std::size_t) { return kBarDensity; },
      [&](const MassPoint& point) {
        for (int a = 0; a < point.nodes.count; ++a)
          at_points.middleRows(3 * k, 3) +=
              point.shape[a] * rows.middleRows(3 * Eigen::Index{point.nodes[a]}, 3);
        ++k;
      });
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(modes, modes);
  for (Eigen::Index p = 0; p < k; ++p)
    gram += bar.cloud.masses[p] * at_points.middleRows(3 * p, 3).transpose() *
            at_points.middleRows(3 * p, 3);
  const Eigen::MatrixXd factor = gram.llt().matrixL();
  const auto orthonormal = [&factor](const Eigen::MatrixXd& fields) {
    return Eigen::MatrixXd(
        factor.triangularView<Eigen::Lower>().solve(fields.transpose()).transpose());
  };
  rows = orthonormal(rows);
  bar.cloud.basis = orthonormal(at_points);

  bar.strain = random_strain_model(spread_omega(modes, 14.0, 120.0), nonlinearity, 5);
  bar.data = basis_of(bar.cloud, bar.strain, false);
  BasisData& data = bar.data;
  data.vertex_count = bar.mesh.vertices.size();
  data.tetrahedron_count = bar.mesh.tetrahedra.size();
  data.elements.corners = bar.mesh.tetrahedra;
  for (const Tetrahedron& tet : bar.mesh.tetrahedra)
    data.elements.masses.push_back(kBarDensity * signed_volume(bar.mesh, tet));
  data.edges = bar.mesh.edges;
  data.surface = data.interior = {};
  // Every third vertex counts as one inside.
  std::vector<Eigen::Index> outside, inside;
  for (Eigen::Index v = 0; v < n; ++v) (v % 3 == 2 ? inside : outside).push_back(v);
  for (const auto& [ids, block] :
       {std::pair{&outside, &data.surface}, std::pair{&inside, &data.interior}}) {
    block->rows.resize(3 * std::ssize(*ids), modes);
    for (std::size_t i = 0; i < ids->size(); ++i) {
      block->vertex_ids.push_back(static_cast<VertexId>((*ids)[i]));
      block->rest.push_back(bar.mesh.vertices[(*ids)[i]]);
      block->rows.middleRows(3 * static_cast<Eigen::Index>(i), 3) =
          rows.middleRows(3 * (*ids)[i], 3);
    }
  }
  data.load.vertices = {static_cast<VertexId>(outside.back())};
  data.load.forces = {{0.4, -0.3, 0.8}};
  Result<Model::Pointer> model = Model::from_data(data);
  EXPECT_TRUE(model) << (model ? "" : model.error().message);
  bar.model = *model;
  return bar;
}

// Weights of all points of the cloud: the mean of the corners' of its tetrahedron.
inline BoneWeights weights_of_points(const RiggedBar& bar, std::span<const BoneSegment> bones,
                                     double blend) {
  const BoneWeights nodes = weights_near(bar.mesh.vertices, bones, blend);
  BoneWeights weights = BoneWeights::Zero(std::ssize(bar.elements), nodes.cols());
  for (std::size_t k = 0; k < bar.elements.size(); ++k)
    for (const VertexId corner : bar.mesh.tetrahedra[bar.elements[k]])
      weights.row(k) += 0.25 * nodes.row(corner);
  return weights;
}

// Three bones along the bar that meet at their ends.
inline std::vector<BoneSegment> bar_bones() {
  return {{{0.0, 0.05, 0.06}, {0.2, 0.05, 0.06}},
          {{0.2, 0.05, 0.06}, {0.4, 0.05, 0.06}},
          {{0.4, 0.05, 0.06}, {0.6, 0.05, 0.06}}};
}

inline std::shared_ptr<const Skin> bar_skin(const RiggedBar& bar, double blend = 0.08) {
  const auto skin = skin_near_bones(*bar.model, bar_bones(), blend);
  EXPECT_TRUE(skin) << (skin ? "" : skin.error().message);
  return *skin;
}

inline ContactBody make_rigged(const Model::Pointer& model, std::shared_ptr<const Skin> skin,
                               const IntegratorOptions& options, std::string_view method = "ep4") {
  Result<ContactBody> body = ContactBody::create(model, method, options, std::move(skin));
  EXPECT_TRUE(body) << (body ? "" : body.error().message);
  return std::move(*body);
}

}  // namespace tremolo::testing
