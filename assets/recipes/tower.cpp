// An iron lattice tower after Eiffel's, 0.5 m high: four splayed legs of four chords each, three
// platforms, arches between the feet, a lattice shaft, a spire. The legs' feet are not quite on a
// square, so that no two modes are a symmetric pair. Few joints, widely rounded, thick feet:
// elements lose their accuracy in creases (docs/error.md).
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "assets/recipes/recipe.h"
#include "assets/recipes/shapes.h"

namespace tremolo {
namespace {

using shapes::Point;

constexpr double kFirst = 0.095;  // heights of the platforms' middles
constexpr double kSecond = 0.185;
constexpr double kThird = 0.41;
constexpr double kTop = 0.5;
constexpr double kLegChord = 0.0062;  // radii
constexpr double kLegBrace = 0.0052;
constexpr double kShaftChord = 0.0066;
constexpr double kShaftBrace = 0.0058;
constexpr double kRodFillet = 0.007;
constexpr double kSolidFillet = 0.012;  // where rods meet platforms and feet
constexpr double kFoot = 0.01;          // half a foot's height
constexpr double kStretch = 1.04;       // of y against x

struct TowerRod {
  Point a, b;
  double ra, rb;
  Point middle;
  double reach;  // radius of a sphere around the middle that holds the rod
};

struct Tower {
  std::vector<TowerRod> rods;
  void add(const Point& a, const Point& b, double ra, double rb) {
    const Point p(a.x(), kStretch * a.y(), a.z());
    const Point q(b.x(), kStretch * b.y(), b.z());
    rods.push_back({p, q, ra, rb, 0.5 * (p + q), 0.5 * (q - p).norm() + std::max(ra, rb)});
  }
};

// Half the distance between the outer edges of the tower at height z: it narrows like the real
// one's silhouette, steeply at first.
double outer(double z) {
  return 0.0145 + 0.0835 * std::exp(-z / 0.1);
}

// The legs' inner edges: the legs meet above the second platform.
double inner(double z) {
  const double width = z < kSecond ? 0.037 - 0.011 * z / kSecond : 0.0;
  return std::max(0.0, outer(z) - width);
}

// A corner of a leg at height z. leg and corner: 0 to 3 around the axis.
Point leg_corner(int leg, int corner, double z) {
  const double x = corner == 0 || corner == 3 ? outer(z) : inner(z);
  const double y = corner == 0 || corner == 1 ? outer(z) : inner(z);
  return {(leg == 0 || leg == 3 ? 1 : -1) * x, (leg < 2 ? 1 : -1) * y, z};
}

// One panel of a leg: its four chords, a ring on top, crosses.
void add_leg_panel(Tower& tower, int leg, double low, double high) {
  for (int corner = 0; corner < 4; ++corner) {
    const int next = (corner + 1) % 4;
    const Point a = leg_corner(leg, corner, low);
    const Point b = leg_corner(leg, next, low);
    const Point c = leg_corner(leg, corner, high);
    const Point d = leg_corner(leg, next, high);
    tower.add(a, c, kLegChord, kLegChord);
    tower.add(c, d, kLegBrace, kLegBrace);
    // The two outer faces are seen: they have crosses.
    if (corner == 1 || corner == 2) continue;
    tower.add(a, d, kLegBrace, kLegBrace);
    tower.add(b, c, kLegBrace, kLegBrace);
  }
}

void add_legs(Tower& tower) {
  constexpr std::array<double, 3> kLevels = {0.008, kFirst, kSecond};
  for (int leg = 0; leg < 4; ++leg)
    for (int panel = 0; panel + 1 < static_cast<int>(kLevels.size()); ++panel)
      add_leg_panel(tower, leg, kLevels[panel], kLevels[panel + 1]);
}

Point shaft_corner(int corner, double z) {
  const double half = outer(z);
  return {(corner == 0 || corner == 3 ? 1 : -1) * half, (corner < 2 ? 1 : -1) * half, z};
}

void add_shaft(Tower& tower) {
  constexpr std::array<double, 4> kLevels = {kSecond, 0.27, 0.345, kThird};
  for (int i = 0; i + 1 < static_cast<int>(kLevels.size()); ++i)
    for (int corner = 0; corner < 4; ++corner) {
      const int next = (corner + 1) % 4;
      const Point a = shaft_corner(corner, kLevels[i]);
      const Point b = shaft_corner(next, kLevels[i]);
      const Point c = shaft_corner(corner, kLevels[i + 1]);
      const Point d = shaft_corner(next, kLevels[i + 1]);
      tower.add(a, c, kShaftChord, kShaftChord);
      tower.add(c, d, kShaftBrace, kShaftBrace);
      tower.add(a, d, kShaftBrace, kShaftBrace);
      tower.add(b, c, kShaftBrace, kShaftBrace);
    }
}

// The round arches under the first platform, one on each side.
void add_arches(Tower& tower) {
  constexpr int kPieces = 12;
  const auto at = [](int side, double t) {
    const double angle = std::numbers::pi * t;
    const double z = 0.03 + 0.053 * std::sin(angle);
    const double along = -(inner(0.03) + 0.002) * std::cos(angle);
    const double away = outer(z) - 0.002;
    return side < 2 ? Point(along, side == 0 ? away : -away, z)
                    : Point(side == 2 ? away : -away, along, z);
  };
  for (int side = 0; side < 4; ++side)
    for (int i = 0; i < kPieces; ++i)
      tower.add(at(side, static_cast<double>(i) / kPieces), at(side, (i + 1.0) / kPieces),
                kLegBrace, kLegBrace);
}

double rods_distance(const Tower& tower, const Point& p) {
  double nearest = 0.1;
  for (const TowerRod& rod : tower.rods) {
    // Cheaper than the capsule: most rods are too far away to matter.
    const double limit = nearest + kRodFillet + rod.reach;
    if (limit > 0.0 && (p - rod.middle).squaredNorm() > limit * limit) continue;
    nearest =
        shapes::smooth_union(nearest, shapes::capsule(p, rod.a, rod.b, rod.ra, rod.rb), kRodFillet);
  }
  return nearest;
}

// A square slab with a hole: what the visitors stand on.
double gallery(const Point& p, double z, double rim, double half_height, double hole) {
  const double slab =
      shapes::box(p, Point(0, 0, z), Point(rim, kStretch * rim, half_height), 0.002);
  if (hole <= 0.0) return slab;
  return std::max(slab, -shapes::box(p, Point(0, 0, z), Point(hole, kStretch * hole, 0.05), 0.004));
}

double solids_distance(const Point& p) {
  double nearest = gallery(p, kFirst, outer(kFirst) + 0.006, 0.0055, inner(kFirst) - 0.004);
  nearest = std::min(nearest, gallery(p, kSecond, outer(kSecond) + 0.005, 0.005, 0.0));
  nearest = std::min(nearest, gallery(p, kThird, outer(kThird) + 0.006, 0.0045, 0.0));
  const double cabin =
      shapes::capsule(p, Point(0, 0, kThird), Point(0, 0, kThird + 0.024), 0.0095, 0.007);
  const double spire =
      shapes::capsule(p, Point(0, 0, kThird + 0.02), Point(0, 0, kTop), 0.0075, 0.004);
  nearest = shapes::smooth_union(nearest, std::min(cabin, spire), kSolidFillet);
  for (int leg = 0; leg < 4; ++leg) {
    const Point foot = 0.5 * (leg_corner(leg, 0, 0.006) + leg_corner(leg, 2, 0.006));
    nearest = std::min(nearest, shapes::box(p, Point(foot.x(), kStretch * foot.y(), kFoot),
                                            Point(0.024, 0.024, kFoot), 0.002));
  }
  return nearest;
}

// Wanted edge length at height z: small where the first eight modes have their energy and at the
// platforms' joints, which bring most of the error.
double size_at(double z) {
  if (std::abs(z - kFirst) < 0.012 || std::abs(z - kSecond) < 0.012 || (z > 0.4 && z < 0.43))
    return 0.0064;
  if (z > 0.43) return 0.0055;
  if (z > 0.31) return 0.008;
  if (z > kSecond) return 0.0065;
  if (z > 0.1) return 0.0067;
  if (z > 0.02) return 0.007;
  return z > 0.006 ? 0.008 : 0.014;
}

}  // namespace

Recipe tower_recipe() {
  const auto tower = std::make_shared<Tower>();
  add_legs(*tower);
  add_shaft(*tower);
  add_arches(*tower);
  Recipe recipe;
  recipe.name = "tower";
  recipe.bounds = {{-0.125, -0.125, -0.01}, {0.125, 0.125, 0.515}};
  recipe.distance = [tower](const Point& p) {
    const double above =
        shapes::smooth_union(rods_distance(*tower, p), solids_distance(p), kSolidFillet);
    return std::max(above, -p.z());
  };
  recipe.size = [](const Point& p) { return size_at(p.z()); };
  recipe.surface_error = 0.001;
  return recipe;
}

}  // namespace tremolo
