// The recipes by name.
#pragma once

#include <string>
#include <string_view>

#include "assets/recipes/recipe.h"
#include "common/result.h"

namespace tremolo {

// "beam basket bridge horse tower heart"
std::string recipe_names();

// kUsage for an unknown name.
Result<Recipe> find_recipe(std::string_view name);

}  // namespace tremolo
