// A standing horse, 1:10: a rubber figure 0.23 m high. It is sculpted at the size of the animal
// (metres, x towards the head, z up, ground at z = 0) and scaled at the end.
#include <algorithm>
#include <memory>
#include <vector>

#include "assets/recipes/recipe.h"
#include "assets/recipes/strand.h"

namespace tremolo {
namespace {

using Point = Eigen::Vector3d;

constexpr double kHorseScale = 0.1;

struct Horse {
  Strand trunk{{{{-0.60, 0.0, 1.31}, 0.235},
                {{-0.42, 0.0, 1.285}, 0.295},
                {{-0.15, 0.0, 1.225}, 0.295},
                {{0.12, 0.0, 1.195}, 0.315},
                {{0.38, 0.0, 1.190}, 0.335},
                {{0.56, 0.0, 1.21}, 0.27}},
               0.82};
  Strand withers{
      {{{0.18, 0.0, 1.45}, 0.06}, {{0.36, 0.0, 1.52}, 0.075}, {{0.52, 0.0, 1.56}, 0.08}}};
  Strand neck{{{{0.46, 0.0, 1.33}, 0.28},
               {{0.66, 0.01, 1.56}, 0.225},
               {{0.80, 0.025, 1.78}, 0.165},
               {{0.90, 0.04, 1.95}, 0.13},
               {{0.97, 0.05, 2.02}, 0.10}},
              0.62};
  Strand head{{{{0.97, 0.05, 2.03}, 0.095},
               {{1.05, 0.055, 1.95}, 0.118},
               {{1.16, 0.06, 1.82}, 0.098},
               {{1.27, 0.065, 1.675}, 0.080},
               {{1.335, 0.07, 1.59}, 0.074}},
              0.72,
              0.06};
  Strand cheek{
      {{{1.03, 0.055, 1.88}, 0.118}, {{1.07, 0.055, 1.81}, 0.108}, {{1.17, 0.06, 1.72}, 0.062}},
      0.72,
      0.055};
  Strand lips{{{{1.25, 0.07, 1.615}, 0.045}, {{1.305, 0.07, 1.545}, 0.048}}, 1.0};
  std::vector<Strand> eyes{
      Strand{{{{1.075, -0.010, 1.97}, 0.030}, {{1.095, -0.008, 1.945}, 0.026}}},
      Strand{{{{1.075, 0.125, 1.97}, 0.030}, {{1.095, 0.125, 1.945}, 0.026}}}};
  std::vector<Strand> ears{Strand{{{{0.955, 0.105, 2.08}, 0.034},
                                   {{0.965, 0.118, 2.16}, 0.042},
                                   {{0.99, 0.125, 2.27}, 0.014}}},
                           Strand{{{{0.955, -0.005, 2.08}, 0.034},
                                   {{0.96, -0.02, 2.16}, 0.042},
                                   {{0.975, -0.03, 2.27}, 0.014}}}};
  std::vector<Strand> hair;
  std::vector<Strand> limbs;
  Strand tail{{{{-0.74, 0.0, 1.47}, 0.065},
               {{-0.85, 0.01, 1.44}, 0.070},
               {{-0.95, 0.03, 1.25}, 0.085},
               {{-0.985, 0.04, 0.98}, 0.100},
               {{-0.97, 0.04, 0.74}, 0.085},
               {{-0.99, 0.04, 0.52}, 0.030}}};
  std::vector<Strand> hooves;
};

void add_foreleg(Horse* horse, double side, double step) {
  const auto at = [&](double x, double y, double z) {
    // The step grows from the elbow down: the limb swings about the shoulder.
    return Point(x + step * std::clamp((1.0 - z) / 0.8, 0.0, 1.0), side * y, z);
  };
  horse->limbs.push_back(Strand{{{at(0.40, 0.11, 1.42), 0.15},
                                 {at(0.57, 0.16, 1.15), 0.14},
                                 {at(0.47, 0.17, 0.96), 0.115},
                                 {at(0.48, 0.165, 0.76), 0.092},
                                 {at(0.495, 0.16, 0.58), 0.066},
                                 {at(0.505, 0.16, 0.50), 0.073},
                                 {at(0.495, 0.16, 0.42), 0.056},
                                 {at(0.49, 0.16, 0.30), 0.050},
                                 {at(0.495, 0.16, 0.215), 0.064},
                                 {at(0.535, 0.16, 0.13), 0.052}}});
  horse->hooves.push_back(Strand{{{at(0.54, 0.16, 0.12), 0.052},
                                  {at(0.56, 0.16, 0.07), 0.070},
                                  {at(0.575, 0.16, -0.01), 0.088}}});
}

void add_hindleg(Horse* horse, double side, double step) {
  const auto at = [&](double x, double y, double z) {
    return Point(x + step * std::clamp((1.0 - z) / 0.8, 0.0, 1.0), side * y, z);
  };
  horse->limbs.push_back(Strand{{{at(-0.50, 0.10, 1.30), 0.20},
                                 {at(-0.50, 0.13, 1.12), 0.20},
                                 {at(-0.47, 0.16, 0.95), 0.155},
                                 {at(-0.56, 0.165, 0.77), 0.100},
                                 {at(-0.675, 0.165, 0.62), 0.074},
                                 {at(-0.685, 0.165, 0.54), 0.074},
                                 {at(-0.665, 0.165, 0.44), 0.059},
                                 {at(-0.645, 0.165, 0.31), 0.053},
                                 {at(-0.635, 0.165, 0.22), 0.066},
                                 {at(-0.595, 0.165, 0.135), 0.054}}});
  // The stifle in front of the thigh and the point of the hock behind the joint.
  horse->limbs.push_back(Strand{{{at(-0.40, 0.15, 1.10), 0.13}, {at(-0.36, 0.16, 0.97), 0.10}}});
  horse->limbs.push_back(Strand{{{at(-0.66, 0.165, 0.72), 0.032},
                                 {at(-0.745, 0.165, 0.655), 0.038},
                                 {at(-0.72, 0.165, 0.54), 0.036}}});
  horse->hooves.push_back(Strand{{{at(-0.59, 0.165, 0.12), 0.054},
                                  {at(-0.57, 0.165, 0.07), 0.070},
                                  {at(-0.555, 0.165, -0.01), 0.088}}});
}

// The crest of the neck carries a roll of hair, from which locks fall to the right side.
void add_mane(Horse* horse) {
  horse->hair.push_back(Strand{{{{1.02, 0.05, 2.09}, 0.040},
                                {{0.91, 0.04, 2.09}, 0.050},
                                {{0.79, 0.02, 1.99}, 0.055},
                                {{0.67, 0.0, 1.84}, 0.055},
                                {{0.55, 0.0, 1.69}, 0.050},
                                {{0.44, 0.0, 1.58}, 0.040}}});
  horse->hair.push_back(  // the forelock
      Strand{
          {{{0.98, 0.05, 2.10}, 0.040}, {{1.07, 0.05, 2.05}, 0.038}, {{1.12, 0.05, 1.97}, 0.025}}});
  const std::vector<Point> roots = {{0.90, 0.0, 2.05},
                                    {0.815, -0.01, 1.965},
                                    {0.735, -0.02, 1.875},
                                    {0.655, -0.03, 1.78},
                                    {0.575, -0.03, 1.68}};
  double length = 0.24;
  for (const Point& root : roots) {
    const Point middle = root + Point(0.05, -0.10, -0.5 * length);
    const Point tip = middle + Point(-0.01, -0.045, -0.6 * length);
    horse->hair.push_back(Strand{{{root, 0.055}, {middle, 0.055}, {tip, 0.022}}});
    length += 0.02;
  }
}

Horse make_horse() {
  Horse horse;
  add_foreleg(&horse, -1.0, 0.02);
  add_foreleg(&horse, 1.0, 0.10);
  add_hindleg(&horse, -1.0, -0.02);
  add_hindleg(&horse, 1.0, 0.10);
  add_mane(&horse);
  return horse;
}

double join(double d, const Strand& strand, const Point& p, double width) {
  return shapes::smooth_union(d, strand.distance(p, width), width);
}

double horse_distance(const Horse& horse, const Point& p) {
  double d = join(horse.trunk.distance(p, 0.12), horse.withers, p, 0.12);
  d = join(d, horse.neck, p, 0.10);
  for (const Strand& limb : horse.limbs) d = join(d, limb, p, 0.055);
  double head = join(horse.head.distance(p, 0.05), horse.cheek, p, 0.04);
  head = join(head, horse.lips, p, 0.03);
  for (const Strand& eye : horse.eyes) head = join(head, eye, p, 0.015);
  d = shapes::smooth_union(d, head, 0.05);
  for (const Strand& ear : horse.ears) d = join(d, ear, p, 0.025);
  d = join(d, horse.tail, p, 0.05);
  for (const Strand& lock : horse.hair) d = join(d, lock, p, 0.025);
  for (const Strand& hoof : horse.hooves) d = join(d, hoof, p, 0.02);
  return std::max(d, -p.z());
}

// Fine at hair and ears, middling at head and legs, coarse in the trunk.
double horse_size(const Horse& horse, const Point& p) {
  const double coarse = p.z() < 0.75 || (p.x() > 0.85 && p.z() > 1.45) ? 0.044 : 0.070;
  double detail = horse.lips.distance(p, 0.1);
  for (const Strand& eye : horse.eyes) detail = std::min(detail, eye.distance(p, 0.1));
  for (const Strand& ear : horse.ears) detail = std::min(detail, ear.distance(p, 0.1));
  for (const Strand& lock : horse.hair) detail = std::min(detail, lock.distance(p, 0.1));
  return std::clamp(0.030 + 0.3 * detail, 0.030, coarse);
}

}  // namespace

Recipe horse_recipe() {
  const auto horse = std::make_shared<const Horse>(make_horse());
  Recipe recipe;
  recipe.name = "horse";
  recipe.bounds = {Point(-1.15, -0.42, -0.03) * kHorseScale, Point(1.5, 0.42, 2.35) * kHorseScale};
  recipe.distance = [horse](const Point& p) {
    return kHorseScale * horse_distance(*horse, p / kHorseScale);
  };
  recipe.size = [horse](const Point& p) {
    return kHorseScale * horse_size(*horse, p / kHorseScale);
  };
  recipe.surface_error = 0.0055 * kHorseScale;
  return recipe;
}

}  // namespace tremolo
