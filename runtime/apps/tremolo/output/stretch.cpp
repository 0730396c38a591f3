#include "runtime/apps/tremolo/output/stretch.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <Eigen/LU>

namespace tremolo {
namespace {

// Edges (columns) in an orthonormal frame of the triangle's plane, m.
Eigen::Matrix2d plane_edges(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d x = a.normalized();
  const Eigen::Vector3d y = (b - b.dot(x) * x).normalized();
  Eigen::Matrix2d edges;
  edges << a.norm(), b.dot(x), 0.0, b.dot(y);
  return edges;
}

// The inverse of a triangle's edges in its plane; false where it has no area.
bool invert_edges(const Model& model, const Triangle& triangle, Eigen::Matrix2d& inverse) {
  const auto& rest = model.surface().rest;
  const auto corner = [&](int k) { return rest[triangle[k]]; };
  const Eigen::Matrix2d edges = plane_edges(corner(1) - corner(0), corner(2) - corner(0));
  if (!(edges.determinant() > 0.0)) return false;
  inverse = edges.inverse();
  return true;
}

}  // namespace

Eigen::VectorXd largest_gradients(const Model& model) {
  const auto& rows = model.surface().rows;
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(model.modes());
  Eigen::Matrix2d inverse;
  for (const Triangle& triangle : model.triangles()) {
    if (!invert_edges(model, triangle, inverse)) continue;
    for (Eigen::Index i = 0; i < largest.size(); ++i) {
      const auto moved = [&](int k) {
        return Eigen::Vector3d(rows.block<3, 1>(3 * Eigen::Index{triangle[k]}, i));
      };
      Eigen::Matrix<double, 3, 2> edges;
      edges << moved(1) - moved(0), moved(2) - moved(0);
      largest[i] = std::max(largest[i], (edges * inverse).norm());
    }
  }
  return largest;
}

SurfaceStretch::SurfaceStretch(const Model& model)
    : model_(model), positions_(3 * model.surface().vertex_ids.size()) {
  Eigen::Matrix2d inverse;
  for (const Triangle& triangle : model.triangles()) {
    if (!invert_edges(model, triangle, inverse)) continue;  // without area it has no stretch
    triangles_.push_back(triangle);
    rest_inverse_.push_back(inverse);
  }
}

StretchRange SurfaceStretch::measure(const Body& body) {
  StretchRange range;
  if (!body.surface_positions(positions_, SurfaceKind::kBoundary)) return range;
  double smallest = 1.0, largest = 1.0;  // squared
  const auto position = [&](VertexId vertex) {
    return Eigen::Vector3d::Map(positions_.data() + 3 * std::ptrdiff_t{vertex});
  };
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const Eigen::Vector3d origin = position(triangles_[t][0]);
    Eigen::Matrix<double, 3, 2> edges;
    edges << position(triangles_[t][1]) - origin, position(triangles_[t][2]) - origin;
    const Eigen::Matrix<double, 3, 2> gradient = edges * rest_inverse_[t];
    // Eigenvalues of the 2 x 2 Cauchy-Green tensor.
    const Eigen::Matrix2d c = gradient.transpose() * gradient;
    const double middle = 0.5 * c.trace();
    const double half = 0.5 * (c(0, 0) - c(1, 1));
    const double reach = std::sqrt(half * half + c(0, 1) * c(0, 1));
    smallest = std::min(smallest, middle - reach);
    largest = std::max(largest, middle + reach);
  }
  range.smallest = std::sqrt(std::max(smallest, 0.0));
  range.largest = std::sqrt(largest);
  return range;
}

Excursion SurfaceStretch::farthest() const {
  Excursion farthest;
  const VertexBlock& surface = model_.surface();
  double largest = -1.0;  // squared, m^2
  for (std::size_t v = 0; v < surface.rest.size(); ++v) {
    const double distance =
        (Eigen::Vector3d::Map(positions_.data() + 3 * v) - surface.rest[v]).squaredNorm();
    if (distance <= largest) continue;
    largest = distance;
    farthest = {std::sqrt(distance), surface.vertex_ids[v]};
  }
  return farthest;
}

double surface_size(const Model& model) {
  const BoundingBox box = bounding_box(model.surface().rest);
  return (box.high - box.low).maxCoeff();
}

using Eigen::Index;

namespace {

constexpr double kRecord = 1.05;

}  // namespace

ShapeLooks::ShapeLooks(const Model& model, std::int64_t least, std::int64_t steps)
    : least_(least),
      every_(std::max(least, steps / kLooks)),
      reach_(Eigen::VectorXd::Zero(model.modes())),
      strain_(largest_gradients(model)) {
  const VertexBlock& surface = model.surface();
  for (Index v = 0; v < static_cast<Index>(surface.rest.size()); ++v)
    reach_ = reach_.cwiseMax(surface.rows.middleRows<3>(3 * v).colwise().norm().transpose());
}

bool ShapeLooks::due(std::int64_t step, const Eigen::VectorXd& q) {
  if (step % every_ == 0) return true;
  if (step % least_ != 0) return false;
  const double bound = q.cwiseAbs().dot(reach_);
  if (!(bound > kRecord * record_)) return false;
  record_ = bound;
  return true;
}

bool ShapeLooks::can_exceed(const Eigen::VectorXd& q, double displacement,
                            const StretchRange& range) const {
  const double strain = q.cwiseAbs().dot(strain_);
  return q.cwiseAbs().dot(reach_) > displacement || 1.0 + strain > range.largest ||
         1.0 - strain < range.smallest;
}

}  // namespace tremolo
