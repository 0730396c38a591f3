// Closed surfaces that something was done to.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "tests/corpus/corpus.h"
#include "tests/corpus/files.h"
#include "tests/corpus/shapes.h"

namespace tremolo::corpus {
namespace {

Shape with_some_flipped(Shape shape, double share, std::uint32_t seed) {
  Dice dice(seed);
  for (Polygon& face : shape.faces)
    if (dice.unit() < share) std::reverse(face.begin(), face.end());
  return shape;
}

Shape with_patch_flipped(Shape shape) {
  for (Polygon& face : shape.faces)
    if (centre_of(shape, face).x() > 0.7) std::reverse(face.begin(), face.end());
  return shape;
}

Shape with_holes(const Shape& shape, int count, double radius, std::uint32_t seed) {
  Dice dice(seed);
  std::vector<Vector3d> holes;
  for (int i = 0; i < count; ++i) holes.push_back(dice.direction());
  return without(shape, [&](std::size_t, const Vector3d& centre) {
    return std::any_of(holes.begin(), holes.end(),
                       [&](const Vector3d& hole) { return (centre - hole).norm() < radius; });
  });
}

Shape with_repeats(Shape shape, bool turned) {
  const std::size_t count = shape.faces.size();
  for (std::size_t f = 0; f < count; f += 3) {
    Polygon face = shape.faces[f];
    if (turned)
      std::reverse(face.begin(), face.end());
    else
      std::rotate(face.begin(), face.begin() + 1, face.end());
    shape.faces.push_back(std::move(face));
  }
  return shape;
}

// Triangles without area: a corner twice, a needle to an edge's end, three points on a line.
Shape with_degenerate(Shape shape) {
  const std::size_t count = shape.faces.size();
  for (std::size_t f = 0; f < count; f += 7) {
    const Polygon face = shape.faces[f];
    const int middle = static_cast<int>(shape.points.size());
    shape.points.push_back((shape.points[face[0]] + shape.points[face[1]]) / 2);
    shape.faces.push_back({face[0], face[0], face[1]});
    shape.faces.push_back({face[0], middle, face[1]});
    shape.faces.push_back({face[2], face[2], face[2]});
  }
  return shape;
}

// The upper half of the faces cut in four, the lower not: the points between do not meet.
Shape with_t_junctions(const Shape& shape) {
  Shape cut;
  cut.points = shape.points;
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int i, int j) {
    const auto [entry, fresh] =
        middles.try_emplace(std::minmax(i, j), static_cast<int>(cut.points.size()));
    if (fresh) cut.points.push_back((cut.points[i] + cut.points[j]) / 2);
    return entry->second;
  };
  for (const Polygon& f : shape.faces) {
    if (centre_of(shape, f).z() < 0.5) {
      cut.faces.push_back(f);
      continue;
    }
    const int a = middle(f[0], f[1]);
    const int b = middle(f[1], f[2]);
    const int c = middle(f[2], f[0]);
    cut.faces.insert(cut.faces.end(), {{f[0], a, c}, {a, f[1], b}, {c, b, f[2]}, {a, b, c}});
  }
  return cut;
}

Shape with_noise(Shape shape, double amount, std::uint32_t seed) {
  Dice dice(seed);
  for (Vector3d& x : shape.points) x += dice.arrow(0, amount);
  return shape;
}

// A scanner's surface: rough, with missing patches where it could not see, crumbs in the air.
Shape scan() {
  Dice dice(7);
  Shape ball = sphere(4);
  for (Vector3d& x : ball.points) x *= 1 + 0.08 * std::sin(5 * x.x()) * x.y();
  ball = with_holes(with_noise(ball, 0.008, 8), 9, 0.13, 9);
  for (int i = 0; i < 25; ++i) {
    const Shape crumb =
        without(sphere(0), [&](std::size_t f, const Vector3d&) { return f % 3 == 0; });
    const double size = dice.between(0.003, 0.02);
    ball = joined(ball, moved(scaled(crumb, size), dice.arrow(1.05, 1.4)));
  }
  return ball;
}

}  // namespace

std::vector<Entry> spoilt_surfaces() {
  const Shape ball = sphere(3);
  const Shape cube = box({0, 0, 0}, {1, 1, 1}, {4, 4, 4});
  const auto above = [](double z) {
    return [z](std::size_t, const Vector3d& centre) { return centre.z() > z; };
  };
  return {
      {"one_hole.obj", "a ball with one small hole", "mesh", obj_bytes(without(ball, above(0.95)))},
      {"many_holes.ply", "a ball with forty small holes", "mesh",
       ply_bytes(with_holes(sphere(4), 40, 0.06, 3), true)},
      {"half_missing.stl", "half of a ball: the other half is missing", "either",
       stl_bytes(without(ball, above(0)), true)},
      {"lid_missing.obj", "a cube without its lid", "either",
       obj_bytes(without(cube, above(0.999)))},
      {"inside_out.obj", "a ball with all triangles turned", "mesh", obj_bytes(flipped(ball))},
      {"third_turned.off", "a ball with a third of its triangles turned", "mesh",
       off_bytes(with_some_flipped(ball, 1.0 / 3, 1))},
      {"patch_turned.ply", "a ball with one patch turned", "mesh",
       ply_bytes(with_patch_flipped(ball), false)},
      {"repeated.obj", "a cube with every third face twice", "mesh",
       obj_bytes(with_repeats(cube, false))},
      {"repeated_turned.off", "a cube with every third face there once more, turned", "mesh",
       off_bytes(with_repeats(cube, true))},
      {"degenerate.obj", "a ball with triangles without area", "mesh",
       obj_bytes(with_degenerate(ball))},
      {"t_junctions.obj", "a cube, fine above and coarse below, points between on edges", "mesh",
       obj_bytes(with_t_junctions(triangulated(cube)))},
      {"soup.ply", "a torus, each triangle with its own points", "mesh",
       ply_bytes(soup(triangulated(torus(1, 0.4, 40, 20))), true)},
      {"gaps.stl", "a ball whose triangles miss each other by 1e-5 of its size", "mesh",
       stl_bytes(with_noise(soup(ball), 1e-5, 5), true)},
      {"wide_gaps.stl", "a ball whose triangles miss each other by 1e-3 of its size", "mesh",
       stl_bytes(with_noise(soup(ball), 1e-3, 6), true)},
      {"scan.ply", "a rough ball from a scanner: patches missing, crumbs in the air", "mesh",
       ply_bytes(scan(), true)},
      {"everything.stl", "a torus: soup, holes, turned, noise, repeats", "mesh",
       stl_bytes(with_noise(soup(with_repeats(
                                with_some_flipped(without(triangulated(torus(1, 0.4, 60, 30)),
                                                          [](std::size_t f, const Vector3d&) {
                                                            return f % 97 == 0;
                                                          }),
                                                  0.1, 4),
                                true)),
                            2e-4, 2),
                 true)},
  };
}

}  // namespace tremolo::corpus
