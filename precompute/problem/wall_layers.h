// How many elements lie across the walls of a tetrahedral mesh, and what that does to frequencies:
// linear tetrahedra are too stiff in bending where there are few, and more so the less the material
// can be compressed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "precompute/problem/problem.h"

namespace tremolo {

// Of the thinnest walls: those that bound a tenth of the surface behind which a wall is found.
// thickness: m. layers: elements across, the length of a line straight through the wall, each piece
// in units of its element's own extent along it; a plate of one cell has 1. edge: of the elements
// there, the longest along the wall, over its thickness.
struct WallLayers {
  double thickness = 0;
  double layers = 0;
  double edge = 0;
};

// Medians, weighted by area, of lines from up to 4 000 faces of the boundary; none where no wall
// has two parallel sides. mesh: positively oriented.
std::optional<WallLayers> find_wall_layers(const TetMesh& mesh);

// How much too high bending frequencies come out, as a share (0.1: by 10 %), to a factor of two or
// so: a fit to plates and bars of known frequencies. poisson: below 1/2.
double frequency_excess(const WallLayers& walls, double poisson);

// What is told of a body: the largest Poisson's ratio of its isotropic materials (none: it has
// none), and what follows.
struct Locking {
  std::optional<WallLayers> walls;
  std::optional<double> poisson;
  std::optional<double> excess;  // frequency_excess
};
Locking find_locking(const Problem& problem);

// One line where the frequencies are off by 3 % or more, else nothing.
std::vector<std::string> describe(const Locking& locking);

// The object `locking` of the programs' JSON: null for what is not known.
nlohmann::ordered_json to_json(const Locking& locking);

}  // namespace tremolo
