// Contact points on a body's surface: each is a weighted sum of control points.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "formats/tets/tets_file.h"
#include "runtime/tets/elements/tet_model.h"

namespace tremolo {

// A contact point.
struct TetPoint {
  std::uint32_t count = 0;
  // Control points of one element; both ends of an edge are included if its control point is.
  std::array<std::uint32_t, kMostNodes> nodes{};
  std::array<double, kMostNodes> shares{};  // weights
  // Twice the mean stiffness at rest of the rows of these nodes by their weights, N/m. A body then
  // penetrates about as much as it deforms there, and the system's condition is unchanged.
  double stiffness = 0.0;
};

// The weighted sum of x, any vector of the control points.
Eigen::Vector3d at_point(const TetPoint& point, const Eigen::VectorXd& x);

// The vertices of the mesh's boundary and the midpoints of its edges.
std::vector<TetPoint> boundary_points(const TetModel& model);

// Vertices of a surface attached to the body, in their order, thinned evenly if there are more than
// the mesh's boundary has vertices and edges.
std::vector<TetPoint> surface_points(const TetModel& model, const TetsSurface& surface);

}  // namespace tremolo
