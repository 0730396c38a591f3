// Building blocks of the recipes: signed distances (m, negative inside) of simple solids, and ways
// to join them. All are exact or bounded by the true distance from below, with Lipschitz constant
// 1, unless said otherwise.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace tremolo::shapes {

using Point = Eigen::Vector3d;

inline double sphere(const Point& p, const Point& centre, double radius) {
  return (p - centre).norm() - radius;
}

// Hull of two spheres, a of radius ra and b of radius rb: a capsule where the radii agree,
// otherwise a tapered one. Exact. If one sphere contains the other, the larger one.
inline double capsule(const Point& p, const Point& a, const Point& b, double ra, double rb) {
  const Point axis = b - a;
  const double length = axis.norm();
  if (length <= std::abs(ra - rb)) return ra > rb ? sphere(p, a, ra) : sphere(p, b, rb);
  // In the half plane through the axis the hull's side leans by this sine against the axis.
  const double sine = (ra - rb) / length;
  const double cosine = std::sqrt(1.0 - sine * sine);
  const Point from_a = p - a;
  const double along = from_a.dot(axis) / length;
  const double across = std::sqrt(std::max(0.0, from_a.squaredNorm() - along * along));
  const double foot = along - across * sine / cosine;
  if (foot <= 0.0) return from_a.norm() - ra;
  if (foot >= length) return (p - b).norm() - rb;
  return across * cosine + along * sine - ra;
}

// Axis-aligned ellipsoid with half axes `radii`. First-order distance: right near the surface, too
// small in size deep inside a flat one.
inline double ellipsoid(const Point& p, const Point& centre, const Point& radii) {
  const Point scaled = (p - centre).cwiseQuotient(radii);
  const double k0 = scaled.norm();
  const double k1 = scaled.cwiseQuotient(radii).norm();
  if (k1 < 1e-12) return -radii.minCoeff();
  return k0 * (k0 - 1.0) / k1;
}

// The same in a turned frame: the columns of `frame` are the directions of the half axes.
inline double ellipsoid(const Point& p, const Point& centre, const Point& radii,
                        const Eigen::Matrix3d& frame) {
  return ellipsoid(frame.transpose() * (p - centre), Point::Zero(), radii);
}

// Axis-aligned box from centre - half to centre + half whose edges are rounded by `radius`.
inline double box(const Point& p, const Point& centre, const Point& half, double radius) {
  const Point outside = ((p - centre).cwiseAbs() - half).array() + radius;
  return outside.cwiseMax(0.0).norm() + std::min(0.0, outside.maxCoeff()) - radius;
}

// Box around the segment a-b: `half` is half its width (level, across) and half its height. The
// ends are cut square; a-b must not be vertical.
inline double plank(const Point& p, const Point& a, const Point& b, const Eigen::Vector2d& half,
                    double radius) {
  const Point along = (b - a).normalized();
  const Point across = Point::UnitZ().cross(along).normalized();
  const Point up = along.cross(across);
  const Point from_middle = p - 0.5 * (a + b);
  const Point local(from_middle.dot(along), from_middle.dot(across), from_middle.dot(up));
  return box(local, Point::Zero(), Point(0.5 * (b - a).norm(), half.x(), half.y()), radius);
}

// Torus around the unit vector `axis`; `ring` to the middle of the tube, `tube` its radius.
inline double torus(const Point& p, const Point& centre, const Point& axis, double ring,
                    double tube) {
  const double height = (p - centre).dot(axis);
  const double radial = (p - centre - height * axis).norm();
  return std::hypot(radial - ring, height) - tube;
}

// Union whose crease is filled over a band of width about k. Never larger than the plain union, and
// at most k / 6 smaller.
inline double smooth_union(double d1, double d2, double k) {
  const double overlap = std::max(k - std::abs(d1 - d2), 0.0) / k;
  return std::min(d1, d2) - overlap * overlap * overlap * k / 6.0;
}

// The part of d1 that is not in d2, the edge rounded over a band of width about k.
inline double smooth_subtract(double d1, double d2, double k) {
  return -smooth_union(-d1, d2, k);
}

inline double smooth_intersect(double d1, double d2, double k) {
  return -smooth_union(-d1, -d2, k);
}

// A point of a tube's centre line and the radius there, m.
struct Station {
  Point centre;
  double radius = 0;
};

// Tapered capsules from station to station: a polyline tube. Exact outside.
inline double tube(const Point& p, std::span<const Station> stations) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < stations.size(); ++i)
    nearest = std::min(nearest, capsule(p, stations[i - 1].centre, stations[i].centre,
                                        stations[i - 1].radius, stations[i].radius));
  return nearest;
}

// Stations along the cubic Bezier curve with control points c, `pieces` + 1 of them; the radius
// goes evenly from `first` to `last`.
inline std::vector<Station> bezier(const std::array<Point, 4>& c, double first, double last,
                                   int pieces) {
  std::vector<Station> stations;
  for (int i = 0; i <= pieces; ++i) {
    const double t = static_cast<double>(i) / pieces;
    const double s = 1.0 - t;
    stations.push_back(
        {s * s * s * c[0] + 3.0 * s * s * t * c[1] + 3.0 * s * t * t * c[2] + t * t * t * c[3],
         s * first + t * last});
  }
  return stations;
}

}  // namespace tremolo::shapes
