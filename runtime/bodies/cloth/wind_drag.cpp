#include "runtime/bodies/cloth/wind_drag.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace tremolo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Corners = std::array<std::uint32_t, 3>;

// Replaces the squared area of a triangle without area.
constexpr double kNoAreaSquare = 1e-300;

// normal: N. flow: N.w. square: |N|^2.
struct WindOnTriangle {
  Vector3d normal, relative;
  double flow = 0.0, square = 0.0;
};

WindOnTriangle wind_on(const Corners& c, const Vector3d& wind, const Eigen::VectorXd& x,
                       const Eigen::VectorXd& v) {
  const Vector3d a = x.segment<3>(3 * c[0]);
  const Vector3d ab = x.segment<3>(3 * c[1]) - a, ac = x.segment<3>(3 * c[2]) - a;
  WindOnTriangle t;
  t.normal = ab.cross(ac);
  t.relative = wind - (v.segment<3>(3 * c[0]) + v.segment<3>(3 * c[1]) + v.segment<3>(3 * c[2])) *
                          (1.0 / 3.0);
  t.flow = t.normal.dot(t.relative);
  t.square = std::max(t.normal.squaredNorm(), kNoAreaSquare);
  return t;
}

// The same halfway, at the mean velocity of a step.
WindOnTriangle wind_over_step(const Corners& c, const Vector3d& wind, const Eigen::VectorXd& x0,
                              const Eigen::VectorXd& x1, double h) {
  const auto middle = [&](int k) -> Vector3d {
    return 0.5 * (x0.segment<3>(3 * c[k]) + x1.segment<3>(3 * c[k]));
  };
  const auto way = [&](int k) -> Vector3d {
    return x1.segment<3>(3 * c[k]) - x0.segment<3>(3 * c[k]);
  };
  const Vector3d a = middle(0), ab = middle(1) - a, ac = middle(2) - a;
  WindOnTriangle t;
  t.normal = ab.cross(ac);
  t.relative = wind - (way(0) + way(1) + way(2)) / (3.0 * h);
  t.flow = t.normal.dot(t.relative);
  t.square = std::max(t.normal.squaredNorm(), kNoAreaSquare);
  return t;
}

Vector3d drag_force(double drag, const WindOnTriangle& t) {
  return (0.25 * drag * std::abs(t.flow) * t.flow / t.square) * t.normal;
}

}  // namespace

WindDrag::WindDrag(const std::vector<Triangle>& triangles, double drag) : drag_(drag) {
  if (drag == 0.0) return;
  for (const Triangle& t : triangles)
    corners_.push_back({static_cast<std::uint32_t>(t[0]), static_cast<std::uint32_t>(t[1]),
                        static_cast<std::uint32_t>(t[2])});
}

void WindDrag::find_places(const BlockPattern& pattern) {
  places_.clear();
  for (const Corners& c : corners_) {
    Places places;
    for (std::size_t k = 0; k < 3; ++k) {
      places.corner[k] = static_cast<std::uint32_t>(pattern.diagonal(c[k]));
      places.edge[k] = static_cast<std::uint32_t>(pattern.find(c[k], c[(k + 1) % 3]));
    }
    places_.push_back(places);
  }
}

void WindDrag::add_force(const Vector3d& wind, const Eigen::VectorXd& x, const Eigen::VectorXd& v,
                         Eigen::VectorXd& f) const {
  for (const Corners& c : corners_) {
    const Vector3d third = (1.0 / 3.0) * drag_force(drag_, wind_on(c, wind, x, v));
    for (const std::uint32_t corner : c) f.segment<3>(3 * corner) += third;
  }
}

StepWork WindDrag::power(const Vector3d& wind, const Eigen::VectorXd& x,
                         const Eigen::VectorXd& v) const {
  StepWork work;
  for (const Corners& c : corners_) {
    const WindOnTriangle t = wind_on(c, wind, x, v);
    const Vector3d force = drag_force(drag_, t);
    work.damped += force.dot(t.relative);
    work.driven += force.dot(wind);
  }
  return work;
}

StepWork WindDrag::add_step_force(const Vector3d& wind, const Eigen::VectorXd& x0,
                                  const Eigen::VectorXd& x1, double h, Eigen::VectorXd& f) const {
  StepWork work;
  for (const Corners& c : corners_) {
    const WindOnTriangle t = wind_over_step(c, wind, x0, x1, h);
    const Vector3d force = drag_force(drag_, t);
    const Vector3d third = (1.0 / 3.0) * force;
    for (const std::uint32_t corner : c) f.segment<3>(3 * corner) += third;
    work.damped += h * force.dot(t.relative);
    work.driven += h * force.dot(wind);
  }
  return work;
}

void WindDrag::add_blocks(std::size_t triangle, const Matrix3d& block, BlockMatrix& a) const {
  for (const std::uint32_t place : places_[triangle].corner) a.block(place) += block;
  for (const std::uint32_t place : places_[triangle].edge) a.block(place) += block;
}

// d(|s| s)/ds = 2 |s|, and each corner has a third of the force and of the velocity.
void WindDrag::add_tangent(const Vector3d& wind, const Eigen::VectorXd& x, const Eigen::VectorXd& v,
                           double velocity, BlockMatrix& a) const {
  if (velocity == 0.0) return;
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const WindOnTriangle t = wind_on(corners_[i], wind, x, v);
    const double slope = velocity * drag_ * std::abs(t.flow) / (18.0 * t.square);
    add_blocks(i, (slope * t.normal) * t.normal.transpose(), a);
  }
}

void WindDrag::add_step_tangent(const Vector3d& wind, const Eigen::VectorXd& x0,
                                const Eigen::VectorXd& x1, double h, BlockMatrix& a) const {
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const WindOnTriangle t = wind_over_step(corners_[i], wind, x0, x1, h);
    const double slope = drag_ * std::abs(t.flow) / (18.0 * h * t.square);
    add_blocks(i, (slope * t.normal) * t.normal.transpose(), a);
  }
}

}  // namespace tremolo
