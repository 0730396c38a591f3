// A rubber bar, 4 : 1 : 0.9, with rounded edges; the section is not square, so that the two bending
// directions have frequencies of their own.
#include "assets/recipes/recipe.h"
#include "assets/recipes/shapes.h"

namespace tremolo {
namespace {

const shapes::Point kHalf(0.2, 0.05, 0.045);
constexpr double kRounding = 0.014;

}  // namespace

Recipe beam_recipe() {
  Recipe recipe;
  recipe.name = "beam";
  recipe.bounds = {{-0.01, -0.06, -0.01}, {0.41, 0.06, 0.1}};
  recipe.distance = [](const shapes::Point& p) {
    return shapes::box(p, shapes::Point(kHalf.x(), 0.0, kHalf.z()), kHalf, kRounding);
  };
  recipe.size = [](const shapes::Point&) { return 0.0160; };
  recipe.surface_error = 0.0008;
  return recipe;
}

}  // namespace tremolo
