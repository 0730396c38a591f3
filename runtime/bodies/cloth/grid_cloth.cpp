// Rows and columns of particles with springs between them.
#include <cmath>
#include <random>
#include <string>

#include "runtime/bodies/cloth/cloth_parts.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

std::uint32_t grid_id(const ClothGrid& grid, std::size_t row, std::size_t column) {
  return static_cast<std::uint32_t>(grid_particle(grid, row, column));
}

// Pairs that are `rows` and `columns` apart: all of one direction first, so that those of a row
// follow each other. columns may be negative.
void join_grid(const ClothGrid& grid, std::size_t rows, int columns, ClothSprings& springs) {
  const std::size_t back = columns < 0 ? static_cast<std::size_t>(-columns) : 0;
  const std::size_t ahead = columns > 0 ? static_cast<std::size_t>(columns) : 0;
  for (std::size_t row = 0; row + rows < grid.rows; ++row)
    for (std::size_t column = back; column + ahead < grid.columns; ++column)
      springs.pairs.emplace_back(grid_id(grid, row, column),
                                 grid_id(grid, row + rows, column + ahead - back));
}

void add_cells(const ClothGrid& grid, double cell_mass, ClothParts& parts) {
  for (std::size_t row = 0; row + 1 < grid.rows; ++row)
    for (std::size_t column = 0; column + 1 < grid.columns; ++column) {
      const auto a = static_cast<VertexId>(grid_id(grid, row, column)), b = a + 1;
      const auto c = static_cast<VertexId>(grid_id(grid, row + 1, column)), d = c + 1;
      if ((row + column) % 2 == 0) {
        parts.triangles.push_back({a, b, d});
        parts.triangles.push_back({a, d, c});
      } else {
        parts.triangles.push_back({a, b, c});
        parts.triangles.push_back({b, d, c});
      }
      for (const VertexId corner : {a, b, c, d}) parts.mass[corner] += 0.25 * cell_mass;
    }
}

}  // namespace

Status measure_springs(const Eigen::VectorXd& x, const char* kind, ClothSprings& springs) {
  springs.rest.clear();
  springs.rest.reserve(springs.pairs.size());
  for (const auto& [a, b] : springs.pairs) {
    const double length = (x.segment<3>(3 * a) - x.segment<3>(3 * b)).norm();
    if (!(length > 0.0))
      return content_error(std::string("a ") + kind + " spring has no length: particles " +
                           std::to_string(a) + " and " + std::to_string(b) + " are in one place");
    springs.rest.push_back(length);
  }
  return Success{};
}

Result<ClothParts> make_grid_cloth(const SceneCloth& cloth) {
  const ClothGrid& grid = cloth.grid;
  const std::size_t n = grid.rows * grid.columns;
  const double wide = grid.width / static_cast<double>(grid.columns - 1);
  const double high = grid.height / static_cast<double>(grid.rows - 1);
  ClothParts parts;
  parts.drag = cloth.drag;
  parts.x.resize(3 * n);
  parts.mass = Eigen::VectorXd::Zero(n);
  for (std::size_t row = 0; row < grid.rows; ++row)
    for (std::size_t column = 0; column < grid.columns; ++column)
      parts.x.segment<3>(3 * grid_id(grid, row, column)) =
          cloth.placed(grid.corner + static_cast<double>(column) * wide * grid.along +
                       static_cast<double>(row) * high * grid.across);
  for (std::size_t row = 0; row < grid.rows; ++row)
    for (std::size_t column = 0; column < grid.columns; ++column)
      parts.uvs.emplace_back(static_cast<float>(column) / static_cast<float>(grid.columns - 1),
                             static_cast<float>(row) / static_cast<float>(grid.rows - 1));
  add_cells(grid, cloth.density * wide * high, parts);
  parts.structural.law = cloth.structural;
  parts.shear.law = cloth.shear;
  parts.bend.law = cloth.bend;
  join_grid(grid, 0, 1, parts.structural);
  join_grid(grid, 1, 0, parts.structural);
  join_grid(grid, 1, 1, parts.shear);
  join_grid(grid, 1, -1, parts.shear);
  join_grid(grid, 0, 2, parts.bend);
  join_grid(grid, 2, 0, parts.bend);
  if (Status s = measure_springs(parts.x, "structural", parts.structural); !s) return s.error();
  if (Status s = measure_springs(parts.x, "shear", parts.shear); !s) return s.error();
  if (Status s = measure_springs(parts.x, "bend", parts.bend); !s) return s.error();
  return parts;
}

Eigen::VectorXd crumpled(const ClothParts& parts, double share,
                         const std::vector<std::uint8_t>& stays) {
  Eigen::VectorXd x = parts.x;
  if (share == 0.0 || parts.structural.rest.empty()) return x;
  double length = 0.0;
  for (const double rest : parts.structural.rest) length += rest;
  length *= share / static_cast<double>(parts.structural.rest.size());
  std::mt19937_64 random(20);
  for (std::size_t i = 0; i < stays.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      // The distributions of standard libraries differ from each other.
      const double part = std::ldexp(static_cast<double>(random() >> 11U), -52) - 1.0;
      if (stays[i] == 0) x[3 * i + k] += length * part;
    }
  return x;
}

}  // namespace tremolo
