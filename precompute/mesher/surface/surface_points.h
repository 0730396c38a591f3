// A first sample of an implicit surface, for the mesher to start from.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "assets/recipes/recipe.h"

namespace tremolo {

// Points on the surface (to 1e-9 of the bounds' diagonal), no two closer than `spacing` times the
// requested size there. They are the sign changes along the edges of a grid of `cells` cells along
// the diagonal, so a member thinner than a cell may be missed. The same recipe gives the same
// points.
std::vector<Eigen::Vector3d> surface_points(const Recipe& recipe, double spacing, int cells);

}  // namespace tremolo
