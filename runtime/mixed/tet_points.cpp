// The contact points of bodies of tetrahedra, their areas and masses.

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include <Eigen/Geometry>

#include "common/mesh/surface_mesh.h"
#include "runtime/mixed/tet_step.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

using Side = std::pair<VertexId, VertexId>;

Side side_of(VertexId a, VertexId b) {
  return {std::min(a, b), std::max(a, b)};
}

// The numbers of boundary_points(): vertices in their order, then edges.
struct PointNumbers {
  std::map<VertexId, std::size_t> vertices;
  std::map<Side, std::size_t> edges;
};

PointNumbers number_points(const std::vector<TetPoint>& points) {
  PointNumbers numbers;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto node = [&](std::size_t k) { return static_cast<VertexId>(points[i].nodes[k]); };
    if (points[i].count == 1)
      numbers.vertices[node(0)] = i;
    else
      numbers.edges[side_of(node(0), node(1))] = i;
  }
  return numbers;
}

// Adds the area of a triangle to its corners in the ratio of their angles, so that the sum does not
// depend on the diagonal that divides a face.
void add_area(const std::array<Vector3d, 3>& corners, const std::array<std::size_t, 3>& numbers,
              std::vector<double>& areas) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3d one = corners[(i + 1) % 3] - corners[i],
                   other = corners[(i + 2) % 3] - corners[i];
    const double twice = one.cross(other).norm();
    areas[numbers[i]] += 0.5 * twice * std::atan2(twice, one.dot(other)) / std::numbers::pi;
  }
}

}  // namespace

std::shared_ptr<const TetPoints> make_tet_points(const TetModel& model) {
  auto made = std::make_shared<TetPoints>();
  made->points = boundary_points(model);
  made->areas.assign(made->points.size(), 0.0);
  const PointNumbers numbers = number_points(made->points);
  const BoundarySurface boundary = boundary_surface(model.mesh());
  for (const Triangle& triangle : boundary.triangles) {
    std::array<Vector3d, 6> at;  // corners, then the middles of the sides opposite to them
    std::array<std::size_t, 6> number{};
    for (std::size_t i = 0; i < 3; ++i) {
      const VertexId own = boundary.vertex_ids[triangle[i]];
      const VertexId a = boundary.vertex_ids[triangle[(i + 1) % 3]];
      const VertexId b = boundary.vertex_ids[triangle[(i + 2) % 3]];
      number[i] = numbers.vertices.at(own);
      number[3 + i] = numbers.edges.at(side_of(a, b));
    }
    for (std::size_t k = 0; k < 6; ++k) at[k] = at_point(made->points[number[k]], model.rest());
    for (const auto& [a, b, c] :
         {std::array<std::size_t, 3>{0, 5, 4}, {5, 1, 3}, {4, 3, 2}, {3, 4, 5}})
      add_area({at[a], at[b], at[c]}, {number[a], number[b], number[c]}, made->areas);
  }
  made->area = std::accumulate(made->areas.begin(), made->areas.end(), 0.0);
  made->extent = (model.rest_box().high - model.rest_box().low).maxCoeff();
  Eigen::VectorXd weight(model.rest().size());
  model.mass_times(Eigen::VectorXd::Ones(model.rest().size()), weight);
  for (const TetPoint& point : made->points) made->masses.push_back(at_point(point, weight).x());
  return made;
}

}  // namespace tremolo
