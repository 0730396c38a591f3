// A displacement at every vertex of a mesh, drawn evenly.
#pragma once

#include <random>

#include "precompute/fem/stvk.h"

namespace tremolo::testing {

// Entries from -size to size, m.
inline Field random_field(const TetMesh& mesh, double size, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> uniform(-size, size);
  Field u(3 * static_cast<Eigen::Index>(mesh.vertices.size()));
  for (double& value : u) value = uniform(engine);
  return u;
}

}  // namespace tremolo::testing
