#include "tests/corpus/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include <Eigen/Geometry>

namespace tremolo::corpus {
namespace {}  // namespace

Vector3d Dice::direction() {
  const double z = between(-1, 1);
  const double angle = between(0, 2 * kPi);
  const double radius = std::sqrt(1 - z * z);
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

Vector3d Dice::arrow(double low, double high) {
  const double length = between(low, high);
  return length * direction();
}

Shape joined(const Shape& a, const Shape& b) {
  Shape both = a;
  const int offset = static_cast<int>(a.points.size());
  both.points.insert(both.points.end(), b.points.begin(), b.points.end());
  for (Polygon face : b.faces) {
    for (int& v : face) v += offset;
    both.faces.push_back(std::move(face));
  }
  return both;
}

Shape mapped(Shape shape, const Map& map) {
  for (Vector3d& x : shape.points) x = map(x);
  return shape;
}

Shape moved(const Shape& shape, const Vector3d& by) {
  return mapped(shape, [&](const Vector3d& x) { return Vector3d(x + by); });
}

Shape scaled(const Shape& shape, double factor) {
  return mapped(shape, [&](const Vector3d& x) { return Vector3d(x * factor); });
}

Shape flipped(Shape shape) {
  for (Polygon& face : shape.faces) std::reverse(face.begin(), face.end());
  return shape;
}

Shape triangulated(const Shape& shape) {
  Shape cut;
  cut.points = shape.points;
  for (const Polygon& face : shape.faces)
    for (std::size_t i = 2; i < face.size(); ++i)
      cut.faces.push_back({face[0], face[i - 1], face[i]});
  return cut;
}

Shape soup(const Shape& shape) {
  Shape apart;
  for (const Polygon& face : shape.faces) {
    Polygon own;
    for (const int v : face) {
      own.push_back(static_cast<int>(apart.points.size()));
      apart.points.push_back(shape.points[v]);
    }
    apart.faces.push_back(std::move(own));
  }
  return apart;
}

Shape welded(const Shape& shape, double distance) {
  // On a lattice much finer than what stays apart: enough for the shapes here.
  std::map<std::array<long long, 3>, int> places;
  Shape one;
  std::vector<int> place_of;
  for (const Vector3d& x : shape.points) {
    const std::array<long long, 3> key = {std::llround(x.x() / distance),
                                          std::llround(x.y() / distance),
                                          std::llround(x.z() / distance)};
    const auto [entry, fresh] = places.try_emplace(key, static_cast<int>(one.points.size()));
    if (fresh) one.points.push_back(x);
    place_of.push_back(entry->second);
  }
  one.faces = shape.faces;
  for (Polygon& face : one.faces)
    for (int& v : face) v = place_of[v];
  return one;
}

Vector3d centre_of(const Shape& shape, const Polygon& face) {
  Vector3d sum = Vector3d::Zero();
  for (const int v : face) sum += shape.points[v];
  return sum / static_cast<double>(face.size());
}

Shape without(const Shape& shape, const std::function<bool(std::size_t, const Vector3d&)>& drop) {
  Shape rest;
  rest.points = shape.points;
  for (std::size_t f = 0; f < shape.faces.size(); ++f)
    if (!drop(f, centre_of(shape, shape.faces[f]))) rest.faces.push_back(shape.faces[f]);
  return rest;
}

Shape sphere(int times) {
  const double g = std::numbers::phi;
  Shape ball;
  for (const double a : {-1.0, 1.0})
    for (const double b : {-g, g}) {
      ball.points.emplace_back(0, a, b);
      ball.points.emplace_back(a, b, 0);
      ball.points.emplace_back(b, 0, a);
    }
  // The faces of the icosahedron: triples at its edge's length of 2.
  const auto neighbours = [&](int i, int j) {
    return std::abs((ball.points[i] - ball.points[j]).norm() - 2) < 1e-9;
  };
  for (int i = 0; i < 12; ++i)
    for (int j = i + 1; j < 12; ++j)
      for (int k = j + 1; k < 12; ++k) {
        if (!neighbours(i, j) || !neighbours(j, k) || !neighbours(i, k)) continue;
        const double side = ball.points[i].dot(ball.points[j].cross(ball.points[k]));
        ball.faces.push_back(side > 0 ? Polygon{i, j, k} : Polygon{i, k, j});
      }
  for (int time = 0; time < times; ++time) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int i, int j) {
      const auto [entry, fresh] =
          middles.try_emplace(std::minmax(i, j), static_cast<int>(ball.points.size()));
      if (fresh) ball.points.push_back((ball.points[i] + ball.points[j]) / 2);
      return entry->second;
    };
    std::vector<Polygon> finer;
    for (const Polygon& f : ball.faces) {
      const int a = middle(f[0], f[1]);
      const int b = middle(f[1], f[2]);
      const int c = middle(f[2], f[0]);
      finer.insert(finer.end(), {{f[0], a, c}, {a, f[1], b}, {c, b, f[2]}, {a, b, c}});
    }
    ball.faces = std::move(finer);
    for (Vector3d& x : ball.points) x.normalize();
  }
  for (Vector3d& x : ball.points) x.normalize();
  return ball;
}

Shape grid(int columns, int rows, bool closed_columns, bool closed_rows,
           const std::function<Vector3d(double, double)>& point) {
  Shape sheet;
  const int across = closed_columns ? columns : columns + 1;
  const int along = closed_rows ? rows : rows + 1;
  for (int j = 0; j < along; ++j)
    for (int i = 0; i < across; ++i)
      sheet.points.push_back(point(double(i) / columns, double(j) / rows));
  const auto at = [&](int i, int j) { return j % along * across + i % across; };
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      sheet.faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
  return sheet;
}

Shape globe(int rings, int segments) {
  const Shape bands = grid(segments, rings, true, false, [](double u, double v) {
    const double polar = kPi * (1 - v);
    return Vector3d(std::sin(polar) * std::cos(2 * kPi * u),
                    std::sin(polar) * std::sin(2 * kPi * u), std::cos(polar));
  });
  // The rows at the poles fall into points; a quad there is a triangle.
  Shape ball = welded(bands, 1e-9);
  for (Polygon& face : ball.faces) face.erase(std::unique(face.begin(), face.end()), face.end());
  for (Polygon& face : ball.faces)
    if (face.front() == face.back()) face.pop_back();
  return ball;
}

Shape box(const Vector3d& low, const Vector3d& high, Eigen::Vector3i cells) {
  Shape sides;
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    for (const bool upper : {false, true}) {
      const Shape side = grid(cells[u], cells[v], false, false, [&](double s, double t) {
        Vector3d x;
        x[axis] = upper ? high[axis] : low[axis];
        x[u] = low[u] + s * (high[u] - low[u]);
        x[v] = low[v] + t * (high[v] - low[v]);
        return x;
      });
      sides = joined(sides, upper ? side : flipped(side));
    }
  }
  return welded(sides, 1e-9 * (high - low).norm());
}

Shape torus(double radius, double thickness, int around, int across) {
  return grid(around, across, true, true, [&](double u, double v) {
    const double r = radius + thickness * std::cos(2 * kPi * v);
    return Vector3d(r * std::cos(2 * kPi * u), r * std::sin(2 * kPi * u),
                    thickness * std::sin(2 * kPi * v));
  });
}

Shape tube(double radius, double height, int segments, int rings) {
  return grid(segments, rings, true, false, [&](double u, double v) {
    return Vector3d(radius * std::cos(2 * kPi * u), radius * std::sin(2 * kPi * u), height * v);
  });
}

Shape cylinder(double radius, double height, int segments, int rings) {
  Shape solid = tube(radius, height, segments, rings);
  Polygon bottom;
  Polygon top;
  for (int i = 0; i < segments; ++i) {
    bottom.push_back(segments - 1 - i);
    top.push_back(rings * segments + i);
  }
  solid.faces.push_back(bottom);
  solid.faces.push_back(top);
  return solid;
}

Shape prism(const std::vector<Eigen::Vector2d>& outline, double height) {
  Shape solid;
  const int n = static_cast<int>(outline.size());
  for (const double z : {0.0, height})
    for (const Eigen::Vector2d& x : outline) solid.points.emplace_back(x.x(), x.y(), z);
  Polygon bottom;
  Polygon top;
  for (int i = 0; i < n; ++i) {
    const int next = (i + 1) % n;
    solid.faces.push_back({i, next, n + next, n + i});
    bottom.push_back(n - 1 - i);
    top.push_back(n + i);
  }
  solid.faces.push_back(bottom);
  solid.faces.push_back(top);
  return solid;
}

std::vector<Eigen::Vector2d> star(int points, double outer, double inner) {
  std::vector<Eigen::Vector2d> outline;
  for (int i = 0; i < 2 * points; ++i) {
    const double radius = i % 2 == 0 ? outer : inner;
    outline.emplace_back(radius * std::cos(kPi * i / points), radius * std::sin(kPi * i / points));
  }
  return outline;
}

// Returns the outline of a plate from x = 0 to 3: squares of `side` cells a side, between them a
// strip of `bend` cells.
std::vector<Eigen::Vector2d> flat_outline(int side, int bend) {
  std::vector<Eigen::Vector2d> outline;
  const int length = 2 * side + bend;
  const auto along = [&](int i) {
    return i <= side          ? double(i) / side
           : i <= side + bend ? 1 + double(i - side) / bend
                              : 2 + double(i - side - bend) / side;
  };
  for (int i = 0; i < length; ++i) outline.emplace_back(along(i), 0);
  for (int i = 0; i < side; ++i) outline.emplace_back(3, double(i) / side);
  for (int i = length; i > 0; --i) outline.emplace_back(along(i), 1);
  for (int i = side; i > 0; --i) outline.emplace_back(0, double(i) / side);
  return outline;
}

Shape bracket() {
  constexpr int kSide = 6;  // cells along a side of the squares about the holes
  constexpr int kBend = 6;  // and between the squares
  constexpr double kHole = 0.25;
  constexpr double kThickness = 0.15;
  // Position at which ray k leaves its square's border, counter-clockwise from a corner.
  const auto border = [](int k) {
    const int side = k / kSide % 4;
    const double s = double(k % kSide) / kSide - 0.5;
    const std::array<Eigen::Vector2d, 4> places = {
        Eigen::Vector2d(s, -0.5), {0.5, s}, {-s, 0.5}, {-0.5, -s}};
    return places[side];
  };
  // The flat plate from x = 0 to 3: square, strip, square; then its walls, and one bend.
  Shape flat;
  for (const double middle : {0.5, 2.5})
    flat = joined(flat, grid(4 * kSide, 3, true, false, [&](double u, double v) {
                    const Eigen::Vector2d out =
                        border(static_cast<int>(std::lround(u * 4 * kSide)));
                    const Eigen::Vector2d x = (1 - v) * out + v * kHole * out.normalized();
                    return Vector3d(middle + x.x(), 0.5 + x.y(), kThickness);
                  }));
  flat = joined(flat, grid(kBend, kSide, false, false,
                           [&](double u, double v) { return Vector3d(1 + u, v, kThickness); }));
  Shape solid = joined(
      flat, flipped(mapped(flat, [](const Vector3d& x) { return Vector3d(x.x(), x.y(), 0); })));
  const auto wall = [&](const std::vector<Eigen::Vector2d>& outline) {
    const int n = static_cast<int>(outline.size());
    solid = joined(solid, grid(n, 2, true, false, [&](double u, double v) {
                     const Eigen::Vector2d& x = outline[std::lround(u * n) % n];
                     return Vector3d(x.x(), x.y(), v * kThickness);
                   }));
  };
  for (const double middle : {0.5, 2.5}) {
    std::vector<Eigen::Vector2d> hole;
    for (int k = 4 * kSide; k-- > 0;)
      hole.push_back(kHole * border(k).normalized() + Eigen::Vector2d(middle, 0.5));
    wall(hole);
  }
  wall(flat_outline(kSide, kBend));
  // About the axis x = 1, z = radius, over the length of the strip.
  const double radius = 2 / kPi;
  return mapped(welded(solid, 1e-6), [radius](const Vector3d& x) {
    if (x.x() <= 1) return x;
    const double angle = std::min(x.x() - 1, 1.0) / radius;
    const double rest = std::max(x.x() - 2, 0.0);
    const double r = radius - x.z();
    return Vector3d(1 + r * std::sin(angle) + rest * std::cos(angle), x.y(),
                    radius - r * std::cos(angle) + rest * std::sin(angle));
  });
}

}  // namespace tremolo::corpus
