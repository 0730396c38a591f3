// Surfaces that cross themselves, have one side only, or edges with more than two faces.
#include <cmath>

#include <Eigen/Geometry>

#include "tests/corpus/corpus.h"
#include "tests/corpus/files.h"
#include "tests/corpus/shapes.h"

namespace tremolo::corpus {
namespace {

Shape turned(const Shape& shape, double angle, const Vector3d& axis) {
  const Eigen::AngleAxisd rotation(angle, axis.normalized());
  return mapped(shape, [&](const Vector3d& x) { return Vector3d(rotation * x); });
}

Shape crossing_tubes() {
  const Shape one = moved(cylinder(0.25, 2, 32, 12), {0, 0, -1});
  return joined(one, turned(one, kPi / 2, Vector3d::UnitX()));
}

// The bottle whose neck runs through its wall, as an immersed tube of figure-8 section.
Shape klein_bottle() {
  return welded(
      grid(64, 24, false, true,
           [](double u, double v) {
             const double a = 2 * kPi * u;
             const double b = 2 * kPi * v;
             const double r =
                 1 + 0.4 * (std::cos(a / 2) * std::sin(b) - std::sin(a / 2) * std::sin(2 * b));
             return Vector3d(
                 r * std::cos(a), r * std::sin(a),
                 0.4 * (std::sin(a / 2) * std::sin(b) + std::cos(a / 2) * std::sin(2 * b)));
           }),
      1e-6);
}

// A figure 8 rotated about an axis next to it: crosses itself along a circle.
Shape figure_eight() {
  return grid(60, 40, true, true, [](double u, double v) {
    const double r = 1 + 0.4 * std::sin(2 * kPi * v);
    return Vector3d(r * std::cos(2 * kPi * u), r * std::sin(2 * kPi * u),
                    0.4 * std::sin(4 * kPi * v));
  });
}

Shape moebius_strip() {
  return welded(grid(60, 6, false, false,
                     [](double u, double v) {
                       const double a = 2 * kPi * u;
                       const double w = 0.3 * (2 * v - 1);
                       const double r = 1 + w * std::cos(a / 2);
                       return Vector3d(r * std::cos(a), r * std::sin(a), w * std::sin(a / 2));
                     }),
                1e-6);
}

Shape three_sheets() {
  Shape sheets;
  for (int i = 0; i < 3; ++i)
    sheets = joined(sheets, turned(grid(6, 6, false, false,
                                        [](double u, double v) { return Vector3d(u, 0, v); }),
                                   2 * kPi * i / 3, Vector3d::UnitZ()));
  return welded(sheets, 1e-6);
}

Shape cube_with_fin() {
  const Shape fin =
      grid(4, 4, false, false, [](double u, double v) { return Vector3d(1 + 0.5 * u, 0.5, v); });
  return welded(joined(box({0, 0, 0}, {1, 1, 1}, {4, 4, 4}), fin), 1e-6);
}

Shape divided_box() {
  const Shape wall = grid(4, 4, false, false, [](double u, double v) { return Vector3d(1, u, v); });
  return welded(joined(box({0, 0, 0}, {2, 1, 1}, {8, 4, 4}), wall), 1e-6);
}

// A trunk and limbs as open tubes that run into each other, as trees in games are made.
Shape tree() {
  Dice dice(11);
  Shape wood = mapped(tube(0.25, 4, 12, 10), [](const Vector3d& x) {
    return Vector3d(x.x() * (1 - 0.15 * x.z()), x.y() * (1 - 0.15 * x.z()), x.z());
  });
  for (int limb = 0; limb < 12; ++limb) {
    const double height = 1.2 + 0.22 * limb;
    const double azimuth = 2.4 * limb;
    const Vector3d axis(-std::sin(azimuth), std::cos(azimuth), 0);
    const Shape branch = mapped(tube(0.09, 1.4, 8, 5), [](const Vector3d& x) {
      return Vector3d(x.x() * (1 - 0.4 * x.z()), x.y() * (1 - 0.4 * x.z()), x.z());
    });
    wood = joined(wood, moved(turned(branch, dice.between(0.7, 1.2), axis), {0, 0, height}));
  }
  return wood;
}

// A tube bent so that it runs through itself once.
Shape loop() {
  const auto centre = [](double t) {
    const double a = 1.6 * kPi * (2 * t - 1);
    return Vector3d(std::sin(a), std::sin(a / 2) * 1.5, 0.1 * std::cos(a));
  };
  Shape skin = grid(16, 80, true, false, [&](double u, double v) {
    const Vector3d tangent = (centre(v + 1e-4) - centre(v - 1e-4)).normalized();
    const Vector3d side = tangent.cross(Vector3d::UnitZ()).normalized();
    const Vector3d up = side.cross(tangent);
    return Vector3d(centre(v) + 0.2 * (std::cos(2 * kPi * u) * side + std::sin(2 * kPi * u) * up));
  });
  Polygon start;
  Polygon end;
  for (int i = 0; i < 16; ++i) {
    start.push_back(15 - i);
    end.push_back(80 * 16 + i);
  }
  skin.faces.push_back(start);
  skin.faces.push_back(end);
  return flipped(skin);
}

}  // namespace

std::vector<Entry> crossing_surfaces() {
  return {
      {"crossing_tubes.obj", "two closed tubes that cross, one mesh", "mesh",
       obj_bytes(crossing_tubes())},
      {"loop.stl", "a tube that runs through itself", "mesh", stl_bytes(loop(), true)},
      {"klein_bottle.ply", "a Klein bottle: closed, but with one side only", "either",
       ply_bytes(klein_bottle(), true)},
      {"figure_eight.obj", "a turned figure 8: one half is inside out", "either",
       obj_bytes(figure_eight())},
      {"moebius.off", "a Moebius strip", "message", off_bytes(moebius_strip())},
      {"three_sheets.obj", "three sheets at one edge", "message", obj_bytes(three_sheets())},
      {"fin.stl", "a cube with a sheet that stands out", "mesh", stl_bytes(cube_with_fin(), false)},
      {"divided_box.obj", "a box with a wall inside", "mesh", obj_bytes(divided_box())},
      {"tree.obj", "a tree of open tubes that run into each other", "either", obj_bytes(tree())},
  };
}

}  // namespace tremolo::corpus
