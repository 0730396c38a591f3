// An oval woven basket with a roped rim and a roped handle, 0.33 m long: willow weavers run in and
// out around upright stakes and are fused to them and to each other. All lengths in metres.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "assets/recipes/recipe.h"
#include "assets/recipes/shapes.h"

namespace tremolo {
namespace {

using shapes::Point;

constexpr double kPi = std::numbers::pi;
constexpr int kStakes = 14;  // even: neighbouring weavers then pass a stake on opposite sides
constexpr int kWeavers = 4;
constexpr double kBottom = 0.009;  // z of the middle of the floor
constexpr double kRim = 0.118;     // z of the middle of the rim
constexpr double kStakeRadius = 0.0098;
constexpr double kWeaverRadius = 0.0108;
constexpr double kFirstWeaver = 0.030;  // z of the lowest weaver
constexpr double kWeaverPitch = 0.021;
constexpr double kWave = 0.005;         // how far a weaver swings in and out
constexpr double kCaneFillet = 0.020;   // rounds the creases between fused canes
constexpr double kWeaveFillet = 0.010;  // the same between neighbouring weavers
constexpr double kRopeFillet = 0.012;   // the same between the two strands of a rope
constexpr double kHandleTop = 0.265;

// Distance of the wall's middle from the axis at height z and angle theta. The wall leans outwards
// and the section is oval and a little egg-shaped, so that no two modes are a symmetric pair.
double wall_radius(double z, double theta) {
  const double flare = 0.100 + 0.33 * z - 0.75 * z * z;
  return flare * (1.0 + 0.13 * std::cos(2.0 * theta) + 0.015 * std::cos(theta - 0.4));
}

struct Polar {
  double radius, theta, z;
};

// A ring-shaped rope of two strands: `offset` from the middle line, `turns` windings around it.
double rope(double radial, double up, double phase, double offset, double strand) {
  const double u = offset * std::cos(phase);
  const double v = offset * std::sin(phase);
  return shapes::smooth_union(std::hypot(radial - u, up - v), std::hypot(radial + u, up + v),
                              kRopeFillet) -
         strand;
}

double weaver(const Polar& p, int row) {
  const double z = kFirstWeaver + kWeaverPitch * row;
  const double swing = kWave * std::cos(0.5 * kStakes * p.theta + kPi * row);
  return std::hypot(p.radius - wall_radius(z, p.theta) - swing, p.z - z) - kWeaverRadius;
}

double stake(const Point& p, const Polar& polar) {
  // Only the two nearest stakes can matter.
  const double spacing = 2.0 * kPi / kStakes;
  const double below = std::floor(polar.theta / spacing);
  double nearest = 1.0;
  for (int i = 0; i < 2; ++i) {
    const double theta = (below + i) * spacing;
    const auto at = [&](double z) {
      const double r = wall_radius(z, theta);
      return Point(r * std::cos(theta), r * std::sin(theta), z);
    };
    const Point foot = at(kBottom + 0.006);
    const Point middle = at(0.5 * kRim);
    const Point top = at(kRim);
    nearest = std::min({nearest, shapes::capsule(p, foot, middle, kStakeRadius, kStakeRadius),
                        shapes::capsule(p, middle, top, kStakeRadius, kStakeRadius)});
  }
  return nearest;
}

double rim(const Polar& p) {
  return rope(p.radius - wall_radius(kRim, p.theta), p.z - kRim, 11.0 * p.theta, 0.0042, 0.0100);
}

// Thick, and under the middle of the wall, which leans outwards: little stress is left at the edges
// of what is held under it.
double foot_ring(const Polar& p) {
  const double out = p.radius - wall_radius(kBottom, p.theta) - 0.003;
  return std::hypot(out, p.z - kBottom - 0.001) - 0.0120;
}

double floor_plate(const Polar& p) {
  const double edge = p.radius - wall_radius(kBottom, p.theta);
  const double ripple = 0.0012 * std::cos(2.0 * kPi * p.radius / 0.021);
  const double flat = std::abs(p.z - kBottom) - 0.0060 - ripple;
  return std::hypot(std::max(edge, 0.0), std::max(flat, 0.0)) + std::min(std::max(edge, flat), 0.0);
}

// Half an ellipse over the long axis, standing on the rim and leaning a little to one side.
double handle(const Point& p) {
  const double foot = wall_radius(kRim, 0.0);
  const double rise = kHandleTop - kRim;
  const double lean = 0.03 * (p.z() - kRim);
  // Polar angle in the ellipse's own measure; the distance along its normal to first order.
  const double x = p.x() / foot;
  const double z = (p.z() - kRim) / rise;
  const double level = std::hypot(x, z);
  const double slope = std::hypot(x / foot, z / rise);
  const double across = slope > 1e-9 ? level * (level - 1.0) / slope : -foot;
  const double angle = std::atan2(z, x);
  const double arch = rope(across, p.y() - lean, 12.0 * angle, 0.0040, 0.0105);
  return std::max(arch, kRim - 0.005 - p.z());
}

double basket_distance(const Point& p) {
  const Polar polar{std::hypot(p.x(), p.y()), std::atan2(p.y(), p.x()), p.z()};
  double wall = std::min(rim(polar), foot_ring(polar));
  for (int row = 0; row < kWeavers; ++row) {
    wall = shapes::smooth_union(wall, weaver(polar, row), kWeaveFillet);
  }
  double d = shapes::smooth_union(wall, stake(p, polar), kCaneFillet);
  d = shapes::smooth_union(d, floor_plate(polar), kCaneFillet);
  d = shapes::smooth_union(d, handle(p), kCaneFillet);
  return 0.85 * d;  // the weavers' swing steepens the function by up to a sixth
}

// Finest outside under the foot ring, where the wall's shear ends at what is held.
double basket_size(const Point& p) {
  if (p.z() < kBottom + 0.012) {
    const double out = std::hypot(p.x(), p.y()) - wall_radius(kBottom, std::atan2(p.y(), p.x()));
    if (std::abs(out) >= 0.018) return 0.011;
    return out > 0.0 && p.z() < 0.006 ? 0.0057 : 0.0072;
  }
  return p.z() < kRim + 0.012 ? 0.0080 : 0.0074;
}

}  // namespace

Recipe basket_recipe() {
  Recipe recipe;
  recipe.name = "basket";
  recipe.bounds = {Point(-0.185, -0.155, -0.01), Point(0.185, 0.155, 0.29)};
  recipe.distance = basket_distance;
  recipe.size = basket_size;
  recipe.surface_error = 0.0015;
  return recipe;
}

}  // namespace tremolo
