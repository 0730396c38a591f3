#include "runtime/contact/impact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace tremolo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kHard = 4.0;    // times rebound_speed
constexpr double kTurn = 0.25;   // of the speed, which a part may change at the turning point
constexpr std::size_t kFew = 5;  // bodies of an island whose impacts are all resolved finely

// Numbers of parts of the time of contact: on its way, and at most at the turning point.
struct Resolution {
  double parts, finest;
};
constexpr Resolution kFine{16.0, 128.0}, kCoarse{4.0, 16.0};

// The points of two bodies.
struct Impact {
  double speed = 0.0;                   // the largest, m/s
  double pull = 0.0;                    // the largest relative acceleration along a normal, m/s^2
  double energy = 0.0;                  // of contact, J
  double stiffness = 0.0;               // of all points, N/m^2
  Vector3d normal = Vector3d::Zero();   // sum over the points with their speeds, m/s
  Matrix3d pressed = Matrix3d::Zero();  // of the pair itself, as in ImpactBody
};

bool same_bodies(const ImpactPoint& x, const ImpactPoint& y) {
  return (x.a == y.a && x.b == y.b) || (x.a == y.b && x.b == y.a);
}

// The force of the pair's points on the body a of the first of them, N.
Vector3d force_of(std::span<const ImpactPoint> points) {
  Vector3d force = Vector3d::Zero();
  for (const ImpactPoint& point : points) {
    if (point.distance >= point.law.begins) continue;
    const double pressure =
        make_gap(point.law, point.distance, point.energy, point.distance).pressure;
    force += (point.a == points[0].a ? pressure : -pressure) * point.normal;
  }
  return force;
}

Matrix3d pressed_by(const Vector3d& force) {
  const double size = force.norm();
  return size > 0.0 ? Matrix3d(force * force.transpose() / size) : Matrix3d(Matrix3d::Zero());
}

void push(std::span<ImpactBody> bodies, std::span<const ImpactPoint> points) {
  const Vector3d force = force_of(points);
  const Matrix3d pressed = pressed_by(force);
  const ImpactPoint& one = points[0];
  bodies[one.a].acceleration += force / bodies[one.a].mass;
  bodies[one.a].pressed += pressed;
  if (one.b == ImpactPoint::kCollider) return;
  bodies[one.b].acceleration -= force / bodies[one.b].mass;
  bodies[one.b].pressed += pressed;
}

// True if others push the body along the normal of the impact, more than across it.
bool is_pushed(const ImpactBody& body, const Impact& impact) {
  const Matrix3d others = body.pressed - impact.pressed;
  const double all = others.trace(), n2 = impact.normal.squaredNorm();
  return all > 1e-9 * body.pressed.trace() &&
         impact.normal.dot(others * impact.normal) > 0.5 * n2 * all;
}

// towards: the pair's first point is of the same body.
void add(std::span<const ImpactBody> bodies, const ImpactPoint& point, bool towards, double h,
         Impact& impact) {
  Vector3d speed = bodies[point.a].velocity_at(point.place) - point.collider;
  Vector3d pull = bodies[point.a].acceleration;
  if (point.b != ImpactPoint::kCollider) {
    speed -= bodies[point.b].velocity_at(point.place);
    pull -= bodies[point.b].acceleration;
  }
  const double rate = speed.dot(point.normal);
  if (point.distance + h * std::min(rate, 0.0) > point.law.begins) return;
  impact.speed = std::max(impact.speed, std::abs(rate));
  impact.normal += (towards ? rate : -rate) * point.normal;
  if (point.distance < point.law.begins)
    impact.pull = std::max(impact.pull, std::abs(pull.dot(point.normal)));
  impact.energy += point.energy;
  impact.stiffness += point.law.stiffness;
}

double longest_for(const Impact& impact, const ContactLaw& law, double mass, double change,
                   const Resolution& resolution) {
  if (!(std::max(impact.speed, change) > kHard * law.rebound_speed))
    return std::numeric_limits<double>::infinity();
  const double energy = 0.5 * mass * impact.speed * impact.speed + impact.energy;
  const double depth = std::cbrt(3.0 * energy / impact.stiffness);
  const double time =
      depth > law.linear_from
          ? 0.5 * std::numbers::pi * std::sqrt(2.0 * mass / (impact.stiffness * law.linear_from))
          : 3.0 * depth / std::sqrt(2.0 * energy / mass);
  if (!(impact.pull > 0.0)) return time / resolution.parts;
  return std::clamp(kTurn * impact.speed / impact.pull, time / resolution.finest,
                    time / resolution.parts);
}

// The points of the pair that begins at `first`.
std::span<const ImpactPoint> pair_at(std::span<const ImpactPoint> points, std::size_t first) {
  std::size_t end = first;
  while (end < points.size() && same_bodies(points[first], points[end])) ++end;
  return points.subspan(first, end - first);
}

}  // namespace

double longest_for_impacts(std::span<ImpactBody> bodies, std::span<const ImpactPoint> points,
                           double h, bool inside) {
  for (std::size_t first = 0; first < points.size(); first += pair_at(points, first).size())
    push(bodies, pair_at(points, first));
  double longest = std::numeric_limits<double>::infinity();
  for (std::size_t first = 0; first < points.size();) {
    const std::span<const ImpactPoint> pair = pair_at(points, first);
    const ImpactPoint& one = pair[0];
    const bool two = one.b != ImpactPoint::kCollider;
    Impact impact;
    impact.pressed = pressed_by(force_of(pair));
    for (const ImpactPoint& point : pair) add(bodies, point, point.a == one.a, h, impact);
    double mass = bodies[one.a].mass;
    if (two) mass *= bodies[one.b].mass / (mass + bodies[one.b].mass);
    const bool coarse = bodies.size() > kFew && (is_pushed(bodies[one.a], impact) ||
                                                 (two && is_pushed(bodies[one.b], impact)));
    longest = std::min(longest, longest_for(impact, one.law, mass, inside ? h * impact.pull : 0.0,
                                            coarse ? kCoarse : kFine));
    first += pair.size();
  }
  return longest;
}

}  // namespace tremolo
