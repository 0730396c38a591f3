// Number of elements across the walls of a tetrahedral mesh, and its effect on frequencies: linear
// tetrahedra are too stiff in bending if there are few, the more so the less compressible the
// material.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "precompute/problem/problem.h"

namespace tremolo {

// The thinnest walls: those behind a tenth of the surface area that bounds a wall. thickness: m.
// layers: elements across the wall, measured as the length of a ray through it, each piece in units
// of its element's own extent along the ray; a plate of one cell has 1. edge: longest element edge
// along the wall, over its thickness.
struct WallLayers {
  double thickness = 0;
  double layers = 0;
  double edge = 0;
};

// Returns area-weighted medians over rays from up to 4 000 boundary faces; none if no wall has two
// parallel sides. mesh: positively oriented.
std::optional<WallLayers> find_wall_layers(const TetMesh& mesh);

// Returns the relative error of bending frequencies (0.1: 10 % too high), accurate to about a
// factor of two: a fit to plates and bars with known frequencies. poisson: below 1/2.
double frequency_excess(const WallLayers& walls, double poisson);

// Locking of a body. poisson: the largest Poisson's ratio of its isotropic materials; none if there
// are none. excess: none for quadratic elements, to which the fit does not apply.
struct Locking {
  std::optional<WallLayers> walls;
  std::optional<double> poisson;
  std::optional<double> excess;  // see frequency_excess
};
Locking find_locking(const Problem& problem);

// Returns one line if the frequencies are off by 3 % or more, else nothing. From 10 % on it begins
// with "warning: ".
std::vector<std::string> describe(const Locking& locking);

// Returns the object `locking` of the programs' JSON; unknown values are null.
nlohmann::ordered_json to_json(const Locking& locking);

}  // namespace tremolo
