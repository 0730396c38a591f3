#include <array>

#include "assets/recipes/recipe.h"

namespace tremolo {
namespace {

struct Entry {
  std::string_view name;
  Recipe (*make)();
};

constexpr std::array<Entry, 6> kRecipes = {{{"beam", beam_recipe},
                                            {"basket", basket_recipe},
                                            {"bridge", bridge_recipe},
                                            {"horse", horse_recipe},
                                            {"tower", tower_recipe},
                                            {"heart", heart_recipe}}};

}  // namespace

std::string recipe_names() {
  std::string names;
  for (const Entry& entry : kRecipes) names += (names.empty() ? "" : " ") + std::string(entry.name);
  return names;
}

Result<Recipe> find_recipe(std::string_view name) {
  for (const Entry& entry : kRecipes)
    if (entry.name == name) return entry.make();
  return Error{
      ErrorKind::kUsage,
      "'" + std::string(name) + "' is neither a file nor a recipe; recipes are: " + recipe_names()};
}

}  // namespace tremolo
