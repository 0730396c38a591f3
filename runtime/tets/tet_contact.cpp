#include "runtime/tets/tet_contact.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "common/mesh/surface_mesh.h"

namespace tremolo {
namespace {

constexpr double kOfOwnStiffness = 2.0;

struct Depth {
  double depth = 0.0;  // m, positive inside
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
};

Depth depth_in(const TetObstacle& obstacle, const Eigen::Vector3d& x) {
  const Eigen::Vector3d place = obstacle.pose.rotation.conjugate() * (x - obstacle.pose.position);
  const CollisionDistance found = signed_distance(obstacle.shape, place);
  return {-found.distance, obstacle.pose.rotation * found.normal};
}

}  // namespace

TetContact::TetContact(const TetModel& model, std::vector<TetObstacle> obstacles)
    : obstacles_(std::move(obstacles)) {
  const BoundarySurface boundary = boundary_surface(model.mesh());
  std::vector<double> own(model.nodes(), 0.0);
  for (const TetModelElement& element : model.elements())
    for (std::size_t i = 0; i < kMostNodes; ++i)
      own[element.nodes[i]] += element.stiffness[node_block(i, i)].trace() / 3.0;
  for (const VertexId v : boundary.vertex_ids)
    points_.push_back({{static_cast<std::uint32_t>(v)}, {1.0}, 1, 0.0});
  std::set<std::pair<VertexId, VertexId>> sides;
  for (const Triangle& t : boundary.triangles)
    for (std::size_t c = 0; c < 3; ++c) {
      const VertexId a = boundary.vertex_ids[static_cast<std::size_t>(t[c])];
      const VertexId b = boundary.vertex_ids[static_cast<std::size_t>(t[(c + 1) % 3])];
      sides.emplace(std::min(a, b), std::max(a, b));
    }
  for (std::size_t e = 0; e < model.edges(); ++e) {
    const MeshEdge& edge = model.edge(e);
    if (!sides.contains({std::min(edge.a, edge.b), std::max(edge.a, edge.b)})) continue;
    points_.push_back({{static_cast<std::uint32_t>(edge.a), static_cast<std::uint32_t>(edge.b),
                        static_cast<std::uint32_t>(edge.point)},
                       {0.25, 0.25, 0.5},
                       3,
                       0.0});
  }
  for (Point& point : points_)
    point.stiffness = kOfOwnStiffness * own[point.nodes[static_cast<std::size_t>(point.count - 1)]];
  touches_.reserve(points_.size() * obstacles_.size());
}

Eigen::Vector3d TetContact::at(const Point& point, const Eigen::VectorXd& x) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < static_cast<std::size_t>(point.count); ++i)
    sum += point.shares[i] * x.segment<3>(3 * Eigen::Index{point.nodes[i]});
  return sum;
}

void TetContact::add_forces(const Eigen::VectorXd& s, const Eigen::VectorXd& v,
                            Eigen::VectorXd& f) {
  touches_.clear();
  for (std::size_t p = 0; p < points_.size(); ++p) {
    const Point& point = points_[p];
    const Eigen::Vector3d place = at(point, s);
    for (const TetObstacle& obstacle : obstacles_) {
      const auto [depth, n] = depth_in(obstacle, place);
      if (!(depth > 0.0)) continue;
      const Eigen::Vector3d speed = at(point, v);
      const Eigen::Vector3d along = speed - n.dot(speed) * n;
      const double size = std::sqrt(along.squaredNorm() + kTetCreep * kTetCreep);
      const double pressed = point.stiffness * depth;
      const double rub = obstacle.friction * pressed / size;
      const Eigen::Vector3d force = pressed * n - rub * along;
      for (std::size_t i = 0; i < static_cast<std::size_t>(point.count); ++i)
        f.segment<3>(3 * Eigen::Index{point.nodes[i]}) += point.shares[i] * force;
      const Eigen::Matrix3d of_speed = rub * (Eigen::Matrix3d::Identity() - n * n.transpose() -
                                              along * along.transpose() / (size * size));
      touches_.push_back(
          {static_cast<std::uint32_t>(p), point.stiffness * n * n.transpose(), of_speed});
    }
  }
}

void TetContact::add_stiffness(const TetSystem& system, double velocity_rate, BlockMatrix& a) {
  for (const Touch& touch : touches_) {
    const Point& point = points_[touch.point];
    const Eigen::Matrix3d block = touch.place + velocity_rate * touch.speed;
    for (std::size_t i = 0; i < static_cast<std::size_t>(point.count); ++i)
      for (std::size_t j = 0; j <= i; ++j)
        system.add_block(point.nodes[i], point.nodes[j], point.shares[i] * point.shares[j] * block,
                         a);
  }
}

TetContact::Look TetContact::look(const Eigen::VectorXd& x) const {
  Look seen;
  for (const Point& point : points_)
    for (const TetObstacle& obstacle : obstacles_) {
      const double depth = depth_in(obstacle, at(point, x)).depth;
      if (!(depth > 0.0)) continue;
      seen.energy += 0.5 * point.stiffness * depth * depth;
      seen.depth = std::max(seen.depth, depth);
      ++seen.touching;
    }
  return seen;
}

}  // namespace tremolo
