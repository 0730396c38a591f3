// Solids and sheets as polygons, good ones and spoilt ones, for the corpus of awkward surfaces.
#pragma once

#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include <Eigen/Core>

namespace tremolo::corpus {

using Eigen::Vector3d;
inline constexpr double kPi = std::numbers::pi;
using Polygon = std::vector<int>;

// faces: polygons of indices into points, counter-clockwise seen from outside.
struct Shape {
  std::vector<Vector3d> points;
  std::vector<Polygon> faces;
};

using Map = std::function<Vector3d(const Vector3d&)>;

// The same numbers on every machine, which the distributions of <random> do not promise.
class Dice {
 public:
  explicit Dice(std::uint32_t seed) : engine_(seed) {}
  double unit() { return static_cast<double>(engine_()) / 4294967296.0; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  Vector3d direction();
  // A vector of a length between the two.
  Vector3d arrow(double low, double high);

 private:
  std::mt19937 engine_;
};

Shape joined(const Shape& a, const Shape& b);  // side by side in one mesh, not welded
Shape mapped(Shape shape, const Map& map);     // keeps the order of corners
Shape moved(const Shape& shape, const Vector3d& by);
Shape scaled(const Shape& shape, double factor);
Shape flipped(Shape shape);
Shape triangulated(const Shape& shape);  // polygons as fans: for convex ones
Shape soup(const Shape& shape);          // every face its own points
// Points closer than `distance` become one; faces stay, whatever becomes of them.
Shape welded(const Shape& shape, double distance);
Shape without(const Shape& shape, const std::function<bool(std::size_t, const Vector3d&)>& drop);
Vector3d centre_of(const Shape& shape, const Polygon& face);

// Radius 1 about the origin: an icosahedron's faces cut in four `times` times; and by longitude.
Shape sphere(int times);
Shape globe(int rings, int segments);
// From low to high, each face cut into cells of the given numbers.
Shape box(const Vector3d& low, const Vector3d& high, Eigen::Vector3i cells = {1, 1, 1});
// Points (u, v) of a grid, u in [0, 1], v in [0, 1]; closed: the last column or row is the first.
Shape grid(int columns, int rows, bool closed_columns, bool closed_rows,
           const std::function<Vector3d(double, double)>& point);
Shape torus(double radius, double thickness, int around, int across);
// Along the z axis from 0 to height; without its two ends, or with them.
Shape tube(double radius, double height, int segments, int rings);
Shape cylinder(double radius, double height, int segments, int rings);
// A plate with two round holes, bent by a right angle between them.
Shape bracket();
// A prism of height h over a polygon given counter-clockwise, its ends one polygon each.
Shape prism(const std::vector<Eigen::Vector2d>& outline, double height);
std::vector<Eigen::Vector2d> star(int points, double outer, double inner);

}  // namespace tremolo::corpus
