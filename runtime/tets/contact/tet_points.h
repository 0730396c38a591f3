// Places on a body's surface by which it touches: each is a sum of shares times control points.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "formats/tets/tets_file.h"
#include "runtime/tets/elements/tet_model.h"

namespace tremolo {

// nodes: of one element; the ends of an edge are there wherever its control point is. stiffness:
// twice the mean stiffness at rest of the rows of these nodes by their shares, N/m, so that a body
// sinks in by about as much as it bends there, and the system's condition stays.
struct TetPoint {
  std::uint32_t count = 0;
  std::array<std::uint32_t, kMostNodes> nodes{};
  std::array<double, kMostNodes> shares{};
  double stiffness = 0.0;
};

// The sum of its shares of x, any vector of the control points.
Eigen::Vector3d at_point(const TetPoint& point, const Eigen::VectorXd& x);

// The vertices of the mesh's boundary and the middles of its edges.
std::vector<TetPoint> boundary_points(const TetModel& model);

// Vertices of a surface that hangs on the body, in their order, thinned evenly where there are more
// than the mesh's boundary has vertices and edges.
std::vector<TetPoint> surface_points(const TetModel& model, const TetsSurface& surface);

}  // namespace tremolo
