#include "runtime/contact/impact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace tremolo {
namespace {

using Eigen::Vector3d;

constexpr double kHard = 4.0;      // times rebound_speed
constexpr double kParts = 16.0;    // of the time of contact
constexpr double kFinest = 128.0;  // the same, at the turning point
constexpr double kTurn = 0.25;     // of the speed, which a part may change there

// The points of two bodies.
struct Impact {
  double speed = 0.0;      // the largest, m/s
  double pull = 0.0;       // the largest relative acceleration along a normal, m/s^2
  double energy = 0.0;     // of contact, J
  double stiffness = 0.0;  // of all points, N/m^2
};

bool same_bodies(const ImpactPoint& x, const ImpactPoint& y) {
  return (x.a == y.a && x.b == y.b) || (x.a == y.b && x.b == y.a);
}

void push(std::span<ImpactBody> bodies, const ImpactPoint& point) {
  if (point.distance >= point.law.begins) return;
  const double pressure =
      make_gap(point.law, point.distance, point.energy, point.distance).pressure;
  const Vector3d force = pressure * point.normal;
  bodies[point.a].acceleration += force / bodies[point.a].mass;
  if (point.b != ImpactPoint::kCollider)
    bodies[point.b].acceleration -= force / bodies[point.b].mass;
}

void add(std::span<const ImpactBody> bodies, const ImpactPoint& point, double h, Impact& impact) {
  Vector3d speed = bodies[point.a].velocity_at(point.place) - point.collider;
  Vector3d pull = bodies[point.a].acceleration;
  if (point.b != ImpactPoint::kCollider) {
    speed -= bodies[point.b].velocity_at(point.place);
    pull -= bodies[point.b].acceleration;
  }
  const double rate = speed.dot(point.normal);
  if (point.distance + h * std::min(rate, 0.0) > point.law.begins) return;
  impact.speed = std::max(impact.speed, std::abs(rate));
  if (point.distance < point.law.begins)
    impact.pull = std::max(impact.pull, std::abs(pull.dot(point.normal)));
  impact.energy += point.energy;
  impact.stiffness += point.law.stiffness;
}

double longest_for(const Impact& impact, const ContactLaw& law, double mass, double change) {
  if (!(std::max(impact.speed, change) > kHard * law.rebound_speed))
    return std::numeric_limits<double>::infinity();
  const double energy = 0.5 * mass * impact.speed * impact.speed + impact.energy;
  const double depth = std::cbrt(3.0 * energy / impact.stiffness);
  const double time =
      depth > law.linear_from
          ? 0.5 * std::numbers::pi * std::sqrt(2.0 * mass / (impact.stiffness * law.linear_from))
          : 3.0 * depth / std::sqrt(2.0 * energy / mass);
  if (!(impact.pull > 0.0)) return time / kParts;
  return std::clamp(kTurn * impact.speed / impact.pull, time / kFinest, time / kParts);
}

}  // namespace

double longest_for_impacts(std::span<ImpactBody> bodies, std::span<const ImpactPoint> points,
                           double h, bool inside) {
  for (const ImpactPoint& point : points) push(bodies, point);
  double longest = std::numeric_limits<double>::infinity();
  for (std::size_t first = 0; first < points.size();) {
    const ImpactPoint& one = points[first];
    Impact impact;
    std::size_t k = first;
    for (; k < points.size() && same_bodies(one, points[k]); ++k) add(bodies, points[k], h, impact);
    double mass = bodies[one.a].mass;
    if (one.b != ImpactPoint::kCollider) mass *= bodies[one.b].mass / (mass + bodies[one.b].mass);
    longest = std::min(longest, longest_for(impact, one.law, mass, inside ? h * impact.pull : 0.0));
    first = k;
  }
  return longest;
}

}  // namespace tremolo
