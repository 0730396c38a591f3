#include "precompute/mesher/surface/surface_points.h"

#include <cmath>

#include "common/mesh/point_cells.h"

namespace tremolo {
namespace {

using Point = Eigen::Vector3d;
using Cell = Eigen::Vector3i;

Point crossing(const Recipe& recipe, Point inside, Point outside) {
  const double enough = 1e-9 * recipe.bounds.diagonal();
  while ((outside - inside).norm() > enough) {
    const Point middle = 0.5 * (inside + outside);
    (recipe.distance(middle) < 0.0 ? inside : outside) = middle;
  }
  return 0.5 * (inside + outside);
}

struct Grid {
  Point low;
  double step;
  Cell count;
  Point at(const Cell& c) const { return low + step * c.cast<double>(); }
  std::size_t index(const Cell& c) const {
    return (static_cast<std::size_t>(c[2]) * count[1] + c[1]) * count[0] + c[0];
  }
};

template <class Visit>
void for_each(const Grid& grid, const Visit& visit) {
  Cell c;
  for (c[2] = 0; c[2] < grid.count[2]; ++c[2])
    for (c[1] = 0; c[1] < grid.count[1]; ++c[1])
      for (c[0] = 0; c[0] < grid.count[0]; ++c[0]) visit(c);
}

std::vector<Point> crossings(const Recipe& recipe, const Grid& grid) {
  std::vector<double> values(static_cast<std::size_t>(grid.count[0]) * grid.count[1] *
                             grid.count[2]);
  for_each(grid, [&](const Cell& c) { values[grid.index(c)] = recipe.distance(grid.at(c)); });
  std::vector<Point> points;
  for_each(grid, [&](const Cell& c) {
    for (int axis = 0; axis < 3; ++axis) {
      const Cell next = c + Cell::Unit(axis);
      if (next[axis] == grid.count[axis]) continue;
      const bool here = values[grid.index(c)] < 0.0;
      const bool there = values[grid.index(next)] < 0.0;
      if (here == there) continue;
      points.push_back(here ? crossing(recipe, grid.at(c), grid.at(next))
                            : crossing(recipe, grid.at(next), grid.at(c)));
    }
  });
  return points;
}

}  // namespace

std::vector<Point> surface_points(const Recipe& recipe, double spacing, int cells) {
  const double step = recipe.bounds.diagonal() / cells;
  const Cell count =
      ((recipe.bounds.high - recipe.bounds.low) / step).array().ceil().cast<int>() + 2;
  const Grid grid{recipe.bounds.low - Point::Constant(0.5 * step), step, count};
  const std::vector<Point> all = crossings(recipe, grid);
  double widest = step;
  for (const Point& x : all) widest = std::max(widest, spacing * recipe.size(x));
  PointCells kept(widest);
  for (const Point& x : all) kept.add_if_apart(x, spacing * recipe.size(x));
  return kept.points();
}

}  // namespace tremolo
