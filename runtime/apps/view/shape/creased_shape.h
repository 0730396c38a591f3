// A surface of triangles with sharp edges.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/tet_mesh.h"
#include "runtime/apps/view/shape/collider_shape.h"

namespace tremolo {

// The surface with sharp edges (common/mesh/creases.h); its first vertices are the given ones. A
// vertex has the mean normal, by area, of its triangles. rest: vertices, m.
TriangleShape creased_shape(const std::vector<Eigen::Vector3d>& rest,
                            std::span<const Triangle> triangles);

}  // namespace tremolo
