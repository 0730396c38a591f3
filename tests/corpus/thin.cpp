// Thin solids, sheets, needles; sizes and positions; files without a surface.
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

#include "tests/corpus/corpus.h"
#include "tests/corpus/files.h"
#include "tests/corpus/shapes.h"

namespace tremolo::corpus {
namespace {

Shape sheet(int cells) {
  return grid(cells, cells, false, false, [](double u, double v) { return Vector3d(u, v, 0); });
}

Shape terrain() {
  return grid(60, 60, false, false, [](double u, double v) {
    return Vector3d(u, v,
                    0.08 * std::sin(9 * u) * std::cos(7 * v) + 0.03 * std::sin(23 * u + 17 * v));
  });
}

Shape with_coordinate(Shape shape, double value, std::size_t every) {
  for (std::size_t i = 0; i < shape.points.size(); i += every) shape.points[i].y() = value;
  return shape;
}

}  // namespace

std::vector<Entry> thin_surfaces() {
  const Shape bowl = without(sphere(3), [](std::size_t, const Vector3d& c) { return c.z() > 0.3; });
  return {
      {"plate.stl", "a plate 1 % thick", "mesh",
       stl_bytes(box({0, 0, 0}, {1, 1, 0.01}, {20, 20, 1}), true)},
      {"thin_plate.obj", "a plate 0.1 % thick", "either",
       obj_bytes(box({0, 0, 0}, {1, 1, 0.001}, {20, 20, 1}))},
      {"thin_ball.ply", "a hollow ball, its wall 1 % of its diameter", "either",
       ply_bytes(joined(sphere(4), flipped(scaled(sphere(4), 0.98))), true)},
      {"needle.stl", "a needle, a thousand times as long as thick", "either",
       stl_bytes(cylinder(0.0005, 1, 12, 1), false)},
      {"sheet.obj", "a flat sheet", "message", obj_bytes(sheet(10))},
      {"double_sheet.ply", "a flat sheet with a front and a back: no volume", "message",
       ply_bytes(joined(sheet(10), flipped(sheet(10))), false)},
      {"bowl.ply", "an open bowl", "either", ply_bytes(bowl, true)},
      {"terrain.obj", "a terrain: an open field of heights", "message", obj_bytes(terrain())},
  };
}

std::vector<Entry> odd_files() {
  const Shape ball = sphere(3);
  const Shape cube = box({0, 0, 0}, {1, 1, 1}, {3, 3, 3});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::string binary = stl_bytes(ball, true);
  return {
      {"huge.obj", "a cube of a thousand kilometres", "mesh", obj_bytes(scaled(cube, 1e6))},
      {"tiny.stl", "a cube of a micrometre", "mesh", stl_bytes(scaled(cube, 1e-6), true)},
      {"tiny.obj", "a ball of two micrometres", "mesh", obj_bytes(scaled(ball, 1e-6))},
      {"millimetres.stl", "a torus of 270, millimetres meant but not said", "mesh",
       stl_bytes(torus(100, 35, 48, 24), true)},
      {"far.off", "a ball a thousand times its size from the origin", "mesh",
       off_bytes(moved(ball, {2000, -2000, 500}))},
      {"very_far.off", "a ball so far from the origin that few digits are left", "either",
       off_bytes(moved(ball, {2e5, 2e5, 2e5}))},
      {"one_triangle.stl", "one triangle", "message",
       stl_bytes({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}}, false)},
      {"one_tetrahedron.off", "four triangles: the smallest solid", "mesh",
       off_bytes({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                  {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}})},
      {"lines.obj", "lines only", "message", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\nl 2 3\nl 3 1\n"},
      {"points.ply", "points only, as a scanner gives them", "message",
       ply_bytes({ball.points, {}}, true)},
      {"empty.obj", "an empty file", "message", ""},
      {"letter.stl", "a letter", "message", "Dear reader,\nthis is no surface.\n"},
      {"cut_off.stl", "a binary STL that was cut off", "either",
       binary.substr(0, binary.size() / 2)},
      {"some_nan.ply", "a ball with a few coordinates that are no numbers", "mesh",
       ply_bytes(with_coordinate(ball, nan, 90), true)},
      {"all_nan.ply", "a ball without one good coordinate", "message",
       ply_bytes(with_coordinate(ball, nan, 1), true)},
      {"infinite.ply", "a cube with a corner at infinity", "either",
       ply_bytes(with_coordinate(cube, std::numeric_limits<double>::infinity(), 1000), true)},
      {"one_point.obj", "a cube whose corners are all in one place", "message",
       obj_bytes(scaled(cube, 0))},
      {"on_a_line.obj", "a cube squeezed into a line", "message",
       obj_bytes(mapped(cube, [](const Vector3d& x) { return Vector3d(x.x(), 0, 0); }))},
      {"squeezed.obj", "a cube squeezed flat", "message",
       obj_bytes(mapped(cube, [](const Vector3d& x) { return Vector3d(x.x(), x.y(), 0); }))},
  };
}

}  // namespace tremolo::corpus
