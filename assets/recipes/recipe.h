// A sample model before it is meshed: an implicit solid and the resolution of its mesh.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "common/mesh/tet_mesh.h"
#include "common/result.h"

namespace tremolo {

// All lengths in metres; z is up, the ground is z = 0.
// bounds: a box a little larger than the solid. distance: negative inside, roughly the distance to
// the surface, Lipschitz constant about 1. size: wanted edge length at a point. surface_error:
// wanted distance between the mesh's surface and the implicit one.
struct Recipe {
  std::string_view name;
  BoundingBox bounds;
  std::function<double(const Eigen::Vector3d&)> distance;
  std::function<double(const Eigen::Vector3d&)> size;
  double surface_error = 0;
};

Recipe beam_recipe();
Recipe basket_recipe();
Recipe bridge_recipe();
Recipe horse_recipe();
Recipe tower_recipe();
Recipe heart_recipe();

// "beam basket bridge horse tower heart"
std::string recipe_names();

// kUsage for an unknown name.
Result<Recipe> find_recipe(std::string_view name);

}  // namespace tremolo
