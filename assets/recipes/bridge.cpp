// A through arch bridge, 0.6 m long: two arch ribs, hangers, cross beams between the crowns, a deck
// and an abutment at each end. One rib stands a little higher than the other, so that no two modes
// mirror each other exactly.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "assets/recipes/recipe.h"
#include "assets/recipes/shapes.h"

namespace tremolo {
namespace {

using shapes::Point;

constexpr double kHalfSpan = 0.3;
constexpr double kHalfWidth = 0.06;  // from the middle to a rib
constexpr double kDeck = 0.075;      // height of the deck's middle
constexpr double kHalfDeck = 0.008;
constexpr double kRib = 0.0095;
constexpr double kHanger = 0.0056;
constexpr double kWindBrace = 0.006;
constexpr double kBridgeFillet = 0.010;
constexpr double kThinSize = 0.0058;  // wanted edge length in hangers and braces
constexpr int kPanels = 10;
constexpr int kArchPieces = 40;

struct BridgeRod {
  Point a, b;
  double radius;
};

// The ribs' centre line; side -1 or 1. The ribs lean inwards, as they rise.
Point rib_at(double x, int side) {
  const double t = x / kHalfSpan;
  const double rise = (side > 0 ? 0.165 : 0.158) * (1.0 - t * t);
  return {x, side * (kHalfWidth - 0.09 * rise), kDeck - 0.012 + rise};
}

std::vector<BridgeRod> make_rods() {
  std::vector<BridgeRod> rods;
  for (const int side : {-1, 1}) {
    for (int i = 0; i < kArchPieces; ++i) {
      const double x = kHalfSpan * (2.0 * i / kArchPieces - 1.0);
      rods.push_back({rib_at(x, side), rib_at(x + 2.0 * kHalfSpan / kArchPieces, side), kRib});
    }
    for (int i = 1; i < kPanels; ++i) {
      const double x = kHalfSpan * (2.0 * i / kPanels - 1.0);
      const Point top = rib_at(x, side);
      rods.push_back({top, {x, side * kHalfWidth, kDeck}, kHanger});
    }
  }
  // Above the traffic: straight beams and a zigzag between them.
  for (int i = 3; i <= kPanels - 3; ++i) {
    const double x = kHalfSpan * (2.0 * i / kPanels - 1.0);
    const double next = x + 2.0 * kHalfSpan / kPanels;
    const int side = i % 2 == 0 ? 1 : -1;
    rods.push_back({rib_at(x, -1), rib_at(x, 1), kWindBrace});
    if (i < kPanels - 3) rods.push_back({rib_at(x, side), rib_at(next, -side), kWindBrace});
  }
  return rods;
}

double rods_distance(const std::vector<BridgeRod>& rods, const Point& p, double far) {
  double nearest = far;
  for (const BridgeRod& rod : rods) {
    // Cheaper than the capsule: most rods are too far away to matter.
    const double centre = (p - 0.5 * (rod.a + rod.b)).norm() - 0.5 * (rod.b - rod.a).norm();
    if (centre - rod.radius > nearest + kBridgeFillet) continue;
    nearest = shapes::smooth_union(
        nearest, shapes::capsule(p, rod.a, rod.b, rod.radius, rod.radius), kBridgeFillet);
  }
  return nearest;
}

double deck_distance(const Point& p) {
  const double slab = shapes::box(p, Point(0, 0, kDeck),
                                  Point(kHalfSpan + 0.02, kHalfWidth + 0.012, kHalfDeck), 0.006);
  double abutments = slab;
  for (const int end : {-1, 1})
    abutments =
        shapes::smooth_union(abutments,
                             shapes::box(p, Point(end * (kHalfSpan + 0.012), 0, 0.5 * kDeck),
                                         Point(0.03, kHalfWidth + 0.02, 0.5 * kDeck), 0.008),
                             kBridgeFillet);
  return abutments;
}

// Fine in the hangers and braces, whose bending decides the softest modes, and at their ends;
// coarse in the abutments.
double bridge_size(const std::vector<BridgeRod>& rods, const Point& p) {
  const bool abutment = std::abs(p.x()) > kHalfSpan - 0.015 && p.z() < kDeck;
  const double coarse = abutment ? 0.018 : p.z() < kDeck + 0.012 ? 0.0092 : 0.0070;
  double beside = 1.0;
  for (const BridgeRod& rod : rods)
    if (rod.radius < kRib)
      beside = std::min(beside, shapes::capsule(p, rod.a, rod.b, rod.radius, rod.radius));
  return std::clamp(kThinSize + 0.5 * std::max(0.0, beside), kThinSize, coarse);
}

}  // namespace

Recipe bridge_recipe() {
  const auto rods = std::make_shared<const std::vector<BridgeRod>>(make_rods());
  Recipe recipe;
  recipe.name = "bridge";
  recipe.bounds = {{-0.36, -0.1, -0.01}, {0.36, 0.1, 0.26}};
  recipe.distance = [rods](const Point& p) { return rods_distance(*rods, p, deck_distance(p)); };
  recipe.size = [rods](const Point& p) { return bridge_size(*rods, p); };
  recipe.surface_error = 0.0016;
  return recipe;
}

}  // namespace tremolo
