// A human heart, a soft teaching model 0.33 m high (twice life size), seen from the front along +y:
// its own left is at +x, its back at +y, z is up. Sculpted in centimetres of the living size about
// the middle of the base of the ventricles, then lifted so that the apex is near z = 0.
#include <algorithm>
#include <memory>
#include <vector>

#include "assets/recipes/recipe.h"
#include "assets/recipes/shapes.h"
#include "assets/recipes/strand.h"

namespace tremolo {
namespace {

using shapes::Point;

constexpr double kHeartScale = 0.02;
constexpr double kLift = 6.6;  // cm

// A vessel that ends in the air: its tube, the hollow of its cut end, and how widely the crease
// where it leaves the heart is rounded.
struct CutVessel {
  Strand wall;
  Strand hollow;
  double blend = 0.4;
};

struct Heart {
  std::vector<Strand> chambers;
  std::vector<CutVessel> vessels;
  std::vector<std::vector<shapes::Station>> grooves;
  std::vector<std::vector<shapes::Station>> coronaries;
};

void add_chambers(Heart* heart) {
  heart->chambers = {
      // left ventricle, from the base to the apex
      Strand{{{{-0.1, 0.3, 1.4}, 3.0},
              {{0.8, 0.1, -0.4}, 3.25},
              {{1.7, -0.3, -2.4}, 2.75},
              {{2.6, -0.7, -4.3}, 1.75},
              {{3.05, -0.9, -5.4}, 1.0}}},
      // right ventricle, in front
      Strand{{{{0.3, -2.1, 1.9}, 1.5},
              {{-1.2, -1.5, 0.2}, 2.4},
              {{-0.4, -1.5, -1.7}, 2.1},
              {{1.2, -1.5, -3.6}, 1.3}}},
      // right atrium and its auricle
      Strand{{{{-2.9, 0.6, 3.4}, 1.5}, {{-3.3, 0.2, 2.0}, 1.9}, {{-3.0, 0.4, 0.5}, 1.5}}},
      Strand{{{{-2.9, -0.9, 3.0}, 1.2}, {{-1.8, -1.9, 3.5}, 0.85}, {{-1.1, -2.2, 3.7}, 0.5}}},
      // left atrium, behind, and its auricle
      Strand{{{{-1.6, 2.0, 3.0}, 1.6}, {{0.4, 2.2, 3.0}, 1.9}, {{2.2, 1.8, 3.0}, 1.5}}},
      Strand{{{{2.6, 0.9, 3.0}, 1.2}, {{2.9, -0.4, 2.9}, 0.95}, {{2.5, -1.3, 2.8}, 0.6}}}};
}

void add_vessels(Heart* heart) {
  const auto hollow = [](const Point& end, const Point& inward, double radius) {
    return Strand{{end - 0.5 * inward, radius}, {end + inward, 0.8 * radius}};
  };
  heart->vessels = {
      // ascending aorta, arch and descending aorta, which ends behind the heart
      {Strand{{{{-0.3, -0.4, 2.0}, 1.45},
               {{-0.8, -0.7, 4.2}, 1.4},
               {{-0.7, -0.3, 6.1}, 1.3},
               {{0.5, 0.6, 7.1}, 1.2},
               {{1.8, 1.8, 6.5}, 1.1},
               {{2.3, 2.9, 4.8}, 1.05},
               {{2.3, 3.6, 2.2}, 1.0}}},
       hollow({2.3, 3.85, 1.3}, {0.0, -0.2, 0.9}, 0.55)},
      // its three branches
      {Strand{{{{-0.3, 0.0, 6.8}, 0.70}, {{-0.9, 0.0, 8.1}, 0.62}, {{-1.5, 0.0, 9.3}, 0.62}}},
       hollow({-1.65, 0.0, 9.6}, {0.2, 0.0, -0.5}, 0.33)},
      {Strand{{{{0.55, 0.6, 7.3}, 0.60}, {{0.55, 0.6, 8.4}, 0.52}, {{0.4, 0.6, 9.6}, 0.52}}},
       hollow({0.4, 0.6, 9.9}, {0.0, 0.0, -0.5}, 0.27)},
      {Strand{{{{1.4, 1.2, 7.0}, 0.62}, {{1.9, 1.2, 8.1}, 0.54}, {{2.6, 1.2, 9.2}, 0.54}}},
       hollow({2.75, 1.2, 9.5}, {-0.25, 0.0, -0.45}, 0.28)},
      // pulmonary trunk with its left branch
      {Strand{{{{0.5, -2.4, 1.6}, 1.45},
               {{1.1, -2.2, 3.3}, 1.25},
               {{1.6, -1.2, 4.7}, 1.15},
               {{2.7, 0.0, 5.3}, 0.95},
               {{4.3, 0.8, 5.5}, 0.85}}},
       hollow({4.95, 1.05, 5.55}, {-0.7, -0.2, 0.0}, 0.5)},
      // right pulmonary artery, behind the aorta
      {Strand{{{{1.3, -0.6, 5.0}, 0.9}, {{-1.2, 1.2, 5.2}, 0.9}, {{-4.0, 1.3, 5.0}, 0.78}}},
       hollow({-4.65, 1.3, 5.0}, {0.7, 0.0, 0.0}, 0.45)},
      // superior and inferior vena cava
      {Strand{{{{-2.7, 0.2, 3.0}, 1.1}, {{-2.6, 0.1, 5.2}, 0.95}, {{-2.6, 0.1, 7.6}, 0.95}}},
       hollow({-2.6, 0.1, 8.4}, {0.0, 0.0, -0.8}, 0.58)},
      // The second swings on its crease, in the eighth mode of the heart that is held above.
      {Strand{{{{-2.9, 0.8, 1.0}, 1.1}, {{-2.9, 0.9, -1.2}, 0.9}, {{-2.9, 0.9, -2.6}, 0.9}}},
       hollow({-2.9, 0.9, -3.4}, {0.0, 0.0, 0.8}, 0.52), 1.0},
      // pulmonary veins, two on each side
      {Strand{{{{2.4, 2.0, 3.4}, 0.8}, {{4.4, 2.1, 3.8}, 0.62}}},
       hollow({4.95, 2.1, 3.9}, {-0.5, 0.0, 0.0}, 0.33)},
      {Strand{{{{2.4, 2.0, 2.4}, 0.8}, {{4.3, 2.3, 2.0}, 0.62}}},
       hollow({4.85, 2.35, 1.9}, {-0.5, 0.0, 0.1}, 0.33)},
      {Strand{{{{-2.6, 2.0, 3.2}, 0.8}, {{-5.0, 2.0, 3.3}, 0.62}}},
       hollow({-5.55, 2.0, 3.3}, {0.5, 0.0, 0.0}, 0.33)},
      {Strand{{{{-2.6, 2.0, 2.0}, 0.8}, {{-5.0, 2.1, 1.6}, 0.62}}},
       hollow({-5.5, 2.1, 1.5}, {0.5, 0.0, 0.1}, 0.33)}};
}

double chamber_distance(const Heart& heart, const Point& p) {
  constexpr double kWidth = 0.5;
  double d = heart.chambers.front().distance(p, kWidth);
  for (std::size_t i = 1; i < heart.chambers.size(); ++i) {
    d = shapes::smooth_union(d, heart.chambers[i].distance(p, kWidth), kWidth);
  }
  return d;
}

// Moves p along the gradient until it lies at `height` over the chambers' surface (under it if
// negative).
Point cling(const Heart& heart, Point p, double height) {
  constexpr double kStep = 1e-4;
  for (int i = 0; i < 20; ++i) {
    Point gradient;
    for (int a = 0; a < 3; ++a) {
      const Point e = kStep * Point::Unit(a);
      gradient[a] = (chamber_distance(heart, p + e) - chamber_distance(heart, p - e)) / (2 * kStep);
    }
    p -= (chamber_distance(heart, p) - height) / gradient.squaredNorm() * gradient;
  }
  return p;
}

std::vector<shapes::Station> clinging(const Heart& heart, const std::vector<Point>& path,
                                      double first, double last, double height) {
  constexpr int kPieces = 6;
  const auto spans = static_cast<double>(path.size() - 1);
  std::vector<shapes::Station> stations;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    for (int k = i == 0 ? 0 : 1; k <= kPieces; ++k) {
      const double t = static_cast<double>(k) / kPieces;
      const double whole = (static_cast<double>(i) + t) / spans;
      const double radius = (1.0 - whole) * first + whole * last;
      stations.push_back(
          {cling(heart, (1.0 - t) * path[i] + t * path[i + 1], height * radius), radius});
    }
  }
  return stations;
}

// The two grooves between the ventricles and between them and the right atrium, and the coronary
// arteries that run in the grooves and branch over the walls.
void add_surface(Heart* heart) {
  const std::vector<Point> between_ventricles = {
      {2.1, -3.0, 2.6}, {2.4, -3.3, 1.0}, {2.3, -3.4, -1.2}, {2.5, -3.0, -3.2}, {2.9, -2.2, -5.4}};
  const std::vector<Point> around_base = {{-0.9, -3.6, 3.0},
                                          {-2.0, -3.2, 2.2},
                                          {-3.0, -2.6, 0.9},
                                          {-3.3, -1.8, -0.6},
                                          {-3.0, -0.8, -1.6}};
  heart->grooves = {clinging(*heart, between_ventricles, 0.90, 0.80, 0.55),
                    clinging(*heart, around_base, 0.90, 0.80, 0.55)};
  heart->coronaries = {
      clinging(*heart, between_ventricles, 0.36, 0.26, -0.40),
      clinging(*heart, around_base, 0.36, 0.30, -0.40),
      clinging(*heart, {{2.4, -3.2, 0.6}, {3.4, -2.4, -0.8}, {4.0, -1.2, -2.4}}, 0.30, 0.22, 0.0),
      clinging(*heart, {{2.3, -3.4, -1.4}, {3.1, -2.7, -2.6}, {3.7, -1.6, -4.0}}, 0.28, 0.22, 0.0),
      clinging(*heart, {{-3.0, -2.6, 0.5}, {-1.8, -3.4, -1.2}, {-0.4, -3.4, -2.8}}, 0.22, 0.16,
               0.0)};
}

Heart make_heart() {
  Heart heart;
  add_chambers(&heart);
  add_vessels(&heart);
  add_surface(&heart);
  return heart;
}

double heart_distance(const Heart& heart, const Point& p) {
  double d = chamber_distance(heart, p);
  for (const auto& groove : heart.grooves) {
    d = shapes::smooth_subtract(d, shapes::tube(p, groove), 0.4);
  }
  for (const CutVessel& vessel : heart.vessels) {
    d = shapes::smooth_union(d, vessel.wall.distance(p, vessel.blend), vessel.blend);
  }
  for (const CutVessel& vessel : heart.vessels) {
    d = shapes::smooth_subtract(d, vessel.hollow.distance(p, 0.3), 0.3);
  }
  for (const auto& artery : heart.coronaries) {
    d = shapes::smooth_union(d, shapes::tube(p, artery), 0.2);
  }
  return d;
}

// Fine at the coronary arteries and the thin vessels at the top, coarse in the walls.
double heart_size(const Heart& heart, const Point& p) {
  double artery = 10.0;
  for (const auto& path : heart.coronaries) artery = std::min(artery, shapes::tube(p, path));
  const double coarse = p.z() > 7.8 ? 0.36 : p.z() > 3.5 ? 0.46 : 0.66;
  return std::clamp(0.30 + 0.5 * artery, 0.30, coarse);
}

}  // namespace

Recipe heart_recipe() {
  const auto heart = std::make_shared<const Heart>(make_heart());
  const Point lift(0.0, 0.0, kLift);
  Recipe recipe;
  recipe.name = "heart";
  recipe.bounds = {Point(-6.0, -4.6, -6.9) * kHeartScale + kHeartScale * lift,
                   Point(5.6, 5.2, 10.6) * kHeartScale + kHeartScale * lift};
  recipe.distance = [heart, lift](const Point& p) {
    return kHeartScale * heart_distance(*heart, p / kHeartScale - lift);
  };
  recipe.size = [heart, lift](const Point& p) {
    return kHeartScale * heart_size(*heart, p / kHeartScale - lift);
  };
  recipe.surface_error = 0.04 * kHeartScale;
  return recipe;
}

}  // namespace tremolo
