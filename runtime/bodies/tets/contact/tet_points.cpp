#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <Eigen/Geometry>

#include "common/mesh/surface_mesh.h"
#include "runtime/bodies/tets/contact/tet_contact.h"

namespace tremolo {
namespace {

constexpr double kOfOwnStiffness = 2.0;

// A third of the trace of each control point's own stiffness at rest, N/m.
std::vector<double> own_stiffness(const TetModel& model) {
  std::vector<double> own(model.nodes(), 0.0);
  for (const TetModelElement& element : model.elements())
    for (std::size_t i = 0; i < kMostNodes; ++i)
      own[element.nodes[i]] += element.stiffness[node_block(i, i)].trace() / 3.0;
  return own;
}

void set_stiffness(const std::vector<double>& own, TetPoint& point) {
  double sum = 0.0, shares = 0.0;
  for (std::uint32_t i = 0; i < point.count; ++i) {
    sum += std::abs(point.shares[i]) * own[point.nodes[i]];
    shares += std::abs(point.shares[i]);
  }
  point.stiffness = kOfOwnStiffness * sum / shares;
}

double surface_area(const TetsSurface& surface) {
  double twice = 0.0;
  for (const Triangle& t : surface.triangles) {
    const Eigen::Vector3d& a = surface.vertices[t[0]];
    const Eigen::Vector3d& b = surface.vertices[t[1]];
    const Eigen::Vector3d& c = surface.vertices[t[2]];
    twice += (b - a).cross(c - a).norm();
  }
  return 0.5 * twice;
}

// Vertices of which no two are nearer than `apart`.
std::vector<std::size_t> spread(const std::vector<Eigen::Vector3d>& vertices, double apart) {
  std::vector<std::size_t> kept;
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const bool free = std::none_of(kept.begin(), kept.end(), [&](std::size_t k) {
      return (vertices[k] - vertices[v]).squaredNorm() < apart * apart;
    });
    if (free) kept.push_back(v);
  }
  return kept;
}

// Control points whose polynomial is not zero at a point of an element; for an edge also its ends.
TetPoint hanging_point(const TetModelElement& element, const Eigen::Vector4d& w) {
  const auto values = polynomials_at(2, {w[0], w[1], w[2], w[3]});
  std::array<bool, kMostNodes> used{};
  for (std::size_t i = 0; i < kMostNodes; ++i) used[i] = std::abs(values[i]) > 1e-12;
  for (std::size_t e = 0; e < 6; ++e)
    if (used[4 + e])
      for (const int end : kTetEdges[e]) used[end] = true;
  TetPoint point;
  for (std::size_t i = 0; i < kMostNodes; ++i)
    if (used[i]) {
      point.nodes[point.count] = element.nodes[i];
      point.shares[point.count++] = values[i];
    }
  return point;
}

}  // namespace

Eigen::Vector3d at_point(const TetPoint& point, const Eigen::VectorXd& x) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::uint32_t i = 0; i < point.count; ++i)
    sum += point.shares[i] * x.segment<3>(3 * Eigen::Index{point.nodes[i]});
  return sum;
}

std::vector<TetPoint> boundary_points(const TetModel& model) {
  const BoundarySurface boundary = boundary_surface(model.mesh());
  const std::vector<double> own = own_stiffness(model);
  std::vector<TetPoint> points;
  for (const VertexId v : boundary.vertex_ids)
    points.push_back({1, {static_cast<std::uint32_t>(v)}, {1.0}, 0.0});
  std::set<std::pair<VertexId, VertexId>> sides;
  for (const Triangle& t : boundary.triangles)
    for (std::size_t c = 0; c < 3; ++c) {
      const VertexId a = boundary.vertex_ids[t[c]];
      const VertexId b = boundary.vertex_ids[t[(c + 1) % 3]];
      sides.emplace(std::min(a, b), std::max(a, b));
    }
  for (std::size_t e = 0; e < model.edges(); ++e) {
    const MeshEdge& edge = model.edge(e);
    if (!sides.contains({std::min(edge.a, edge.b), std::max(edge.a, edge.b)})) continue;
    points.push_back({3,
                      {static_cast<std::uint32_t>(edge.a), static_cast<std::uint32_t>(edge.b),
                       static_cast<std::uint32_t>(edge.point)},
                      {0.25, 0.25, 0.5},
                      0.0});
  }
  for (TetPoint& point : points) set_stiffness(own, point);
  return points;
}

std::vector<TetPoint> surface_points(const TetModel& model, const TetsSurface& surface) {
  const std::size_t most = boundary_points(model).size();
  std::vector<std::size_t> kept(surface.vertices.size());
  for (std::size_t v = 0; v < kept.size(); ++v) kept[v] = v;
  double apart = 0.8 * std::sqrt(surface_area(surface) / static_cast<double>(most));
  for (; kept.size() > most; apart *= 1.05) kept = spread(surface.vertices, apart);
  const std::vector<double> own = own_stiffness(model);
  std::vector<TetPoint> points;
  points.reserve(kept.size());
  for (const std::size_t v : kept) {
    points.push_back(hanging_point(model.elements()[surface.tetrahedra[v]], surface.weights[v]));
    set_stiffness(own, points.back());
  }
  return points;
}

}  // namespace tremolo
