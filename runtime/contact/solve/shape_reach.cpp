#include "runtime/contact/solve/shape_reach.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <variant>

#include "common/mesh/tet_mesh.h"
#include "common/text.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr Index kSpread = 300;            // distributed over the sphere, 11 degrees apart
constexpr std::uint32_t kGridSteps = 64;  // nodes of a grid sampled along an axis, at most

// The axes, the diagonals, and points of a spiral on the sphere; 3 x n, of length one.
Matrix3Xd directions() {
  Matrix3Xd all(3, 26 + kSpread);
  Index next = 0;
  for (const int x : {-1, 0, 1})
    for (const int y : {-1, 0, 1})
      for (const int z : {-1, 0, 1})
        if (x != 0 || y != 0 || z != 0) all.col(next++) = Vector3d(x, y, z).normalized();
  for (Index i = 0; i < kSpread; ++i) {
    const double z = (2.0 * static_cast<double>(i) + 1.0) / kSpread - 1.0;
    const double angle = std::numbers::pi * (3.0 - std::sqrt(5.0)) * static_cast<double>(i);
    const double r = std::sqrt(1.0 - z * z);
    all.col(next++) = Vector3d(r * std::cos(angle), r * std::sin(angle), z);
  }
  return all;
}

// The largest n.x of a shape for each direction n, m.
struct Support {
  const Matrix3Xd& n;

  VectorXd operator()(const PlaneShape&) const {
    return VectorXd::Constant(n.cols(), std::numeric_limits<double>::infinity());
  }
  VectorXd operator()(const SphereShape& sphere) const {
    return VectorXd::Constant(n.cols(), sphere.radius);
  }
  VectorXd operator()(const CapsuleShape& capsule) const {
    return capsule.radius + capsule.half_length * n.row(2).cwiseAbs().transpose().array();
  }
  VectorXd operator()(const BoxShape& box) const {
    return n.cwiseAbs().transpose() * box.half_extents;
  }
  VectorXd operator()(const CylinderShape& cylinder) const {
    return cylinder.radius * n.topRows<2>().colwise().norm().transpose() +
           cylinder.half_length * n.row(2).cwiseAbs().transpose();
  }
  // A node at the depth d has a ball of that radius inside the shape.
  VectorXd operator()(const GridShape& shape) const {
    const DistanceGrid& grid = *shape.grid;
    const GridNodes& nodes = grid.nodes();
    std::array<std::size_t, 3> stride;
    for (std::size_t k = 0; k < 3; ++k) stride[k] = 1 + nodes.counts[k] / kGridSteps;
    VectorXd most = VectorXd::Constant(n.cols(), -std::numeric_limits<double>::infinity());
    for (std::size_t k = 0; k < nodes.counts[2]; k += stride[2])
      for (std::size_t j = 0; j < nodes.counts[1]; j += stride[1])
        for (std::size_t i = 0; i < nodes.counts[0]; i += stride[0]) {
          const Vector3d x = nodes.at(i, j, k);
          const double depth = -grid.at(x).distance;
          if (depth < 0.0) continue;
          most = most.cwiseMax(((n.transpose() * x).array() + depth).matrix());
        }
    return most;
  }
};

}  // namespace

ShapeReach shape_beyond(const Model& model, const Collider& shape) {
  const Matrix3Xd n = directions();
  VectorXd beyond = std::visit(Support{n}, shape);
  VectorXd body = VectorXd::Constant(n.cols(), -std::numeric_limits<double>::infinity());
  for (const Vector3d& x : model.surface().rest) body = body.cwiseMax(n.transpose() * x);
  beyond -= body;
  Index at = 0;
  ShapeReach reach;
  reach.distance = beyond.maxCoeff(&at);
  reach.direction = n.col(at);
  const BoundingBox box = bounding_box(model.surface().rest);
  reach.size = (box.high - box.low).maxCoeff();
  return reach;
}

std::string reach_text(const Collider& shape, const ShapeReach& reach) {
  const Vector3d& n = reach.direction;
  const auto rounded = [](double value) { return number_text(0.01 * std::round(100.0 * value)); };
  return std::string("the ") + shape_name(shape) + " extends " + number_text(reach.distance) +
         " m beyond the body along [" + rounded(n.x()) + ", " + rounded(n.y()) + ", " +
         rounded(n.z()) + "], " + number_text(std::round(100.0 * reach.distance / reach.size)) +
         " % of its size";
}

Status check_reach(const Model& model, const Collider& shape) {
  const ShapeReach reach = shape_beyond(model, shape);
  if (reach.distance <= kShapeRefused * reach.size) return Success{};
  return content_error("shape: " + reach_text(shape, reach) + ", more than " +
                       number_text(100.0 * kShapeRefused) +
                       " %: make it smaller, or put it where the mesh is (sizes in m, in the "
                       "mesh's coordinates)");
}

double radius_about(const Collider& shape, const Vector3d& centre) {
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) return centre.norm() + sphere->radius;
  const BoundingBox box = bounds(shape);
  return (box.high - centre).cwiseMax(centre - box.low).norm();
}

}  // namespace tremolo
