// A surface of triangles with sharp edges.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/tet_mesh.h"
#include "runtime/apps/view/shape/collider_shape.h"

namespace tremolo {

// The surface with three vertices of its own for each triangle. A vertex has the mean normal, by
// area, of the triangles around it that meet this one at less than kCrease: edges of boxes and rims
// of cylinders are sharp, and round sides are smooth. rest: vertices, m.
inline constexpr double kCrease = 0.7;  // rad
TriangleShape creased_shape(const std::vector<Eigen::Vector3d>& rest,
                            std::span<const Triangle> triangles);

}  // namespace tremolo
