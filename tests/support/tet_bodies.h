// Meshes of corotated tetrahedra for the tests.
#pragma once

#include <gtest/gtest.h>

#include "runtime/bodies/tets/motion/tet_body.h"
#include "tests/support/meshes/box_mesh.h"
#include "tests/support/meshes/random_tet.h"

namespace tremolo::testing {

inline const Material kTetGel{1e5, 0.4, 1000.0};

// A bar along x, fixed at x = 0 or free.
inline TetModelPointer tet_bar(const std::array<int, 3>& cells, const Eigen::Vector3d& size,
                               bool held, const Material& material = kTetGel) {
  const TetMesh mesh = box_mesh(cells, size);
  const std::vector<VertexId> end =
      held ? vertices_on_plane(mesh, 0, 0.0) : std::vector<VertexId>{};
  auto model = TetModel::create(mesh, {{{"gel", material}}, {}}, end);
  EXPECT_TRUE(model) << model.error().message;
  return *model;
}

inline Eigen::VectorXd random_state(TetRandom& random, Eigen::Index size, double amplitude) {
  Eigen::VectorXd u(size);
  for (double& value : u) value = random.between(-amplitude, amplitude);
  return u;
}

inline std::vector<std::uint8_t> random_degrees(TetRandom& random, std::size_t edges) {
  std::vector<std::uint8_t> degrees(edges);
  for (std::uint8_t& degree : degrees) degree = random.between(0.0, 1.0) < 0.5 ? 1 : 2;
  return degrees;
}

}  // namespace tremolo::testing
