#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>

#include "runtime/bodies/cloth/cloth_parts.h"
#include "runtime/bodies/cloth/cloth_places.h"
#include "runtime/io/scenes/nodal_readers.h"
#include "runtime/io/scenes/part_readers.h"

namespace tremolo {
namespace {

// Adds the particles of one place of the key.
void add_place(TomlKeys& keys, const char* key, const SceneCloth& cloth, const std::string& place,
               std::vector<std::size_t>& particles) {
  std::optional<ClothParts> parts;
  if (place.starts_with("near:")) {
    Result<ClothParts> made = make_cloth_parts(cloth);
    if (!made) return keys.fail(made.error());
    parts = std::move(*made);
  }
  if (Status s = add_cloth_place(cloth, parts ? &*parts : nullptr, place, particles); !s)
    keys.fail(key, s.error().message);
}

// Each particle once, in ascending order.
std::vector<std::size_t> read_places(TomlKeys& keys, const char* key, const SceneCloth& cloth) {
  std::vector<std::string> places;
  keys.read(key, places);
  std::vector<std::size_t> particles;
  for (const std::string& place : places) {
    if (!keys.good()) return {};
    add_place(keys, key, cloth, place, particles);
  }
  std::sort(particles.begin(), particles.end());
  particles.erase(std::unique(particles.begin(), particles.end()), particles.end());
  return particles;
}

Result<ClothPin> read_pin(const toml::table& table, const std::string& path,
                          const std::string& what, std::vector<std::string>& files,
                          const SceneCloth& cloth) {
  ClothPin pin;
  TomlKeys keys(table, path, what);
  if (!keys.has("at")) keys.fail("at", "it has no `at`");
  pin.particles = read_places(keys, "at", cloth);
  keys.read("until", pin.until);
  if (Status s = take(pin.motion, read_motion(keys, path, what, files)); !s) return s.error();
  if (Status s = keys.finish(); !s) return s.error();
  return pin;
}

}  // namespace

std::size_t read_particle(TomlKeys& keys, const char* key, const SceneCloth& cloth) {
  std::string place;
  keys.read_text_or_number(key, place);
  std::vector<std::size_t> particles;
  if (keys.good()) add_place(keys, key, cloth, place, particles);
  if (keys.good() && particles.size() != 1)
    keys.fail(key, "'" + place + "' is " + std::to_string(particles.size()) +
                       " particles, a hand holds one: near:X,Y,Z takes the nearest");
  return keys.good() ? particles.front() : 0;
}

Status read_pins(TomlKeys& keys, const std::string& path, const std::string& what,
                 std::vector<std::string>& files, SceneCloth& cloth) {
  const toml::node* node = keys.find("pins");
  if (node == nullptr) return Success{};
  const toml::array* array = node->as_array();
  const bool tables =
      node->is_table() || (array != nullptr && !array->empty() && array->get(0)->is_table());
  if (!tables) {
    ClothPin pin;
    pin.particles = read_places(keys, "pins", cloth);
    cloth.pins.push_back(std::move(pin));
    return Success{};
  }
  for (const toml::table* entry : keys.read_tables("pins")) {
    Result<ClothPin> pin = read_pin(*entry, path, what + ", pins", files, cloth);
    if (!pin) return pin.error();
    cloth.pins.push_back(std::move(*pin));
  }
  return Success{};
}

}  // namespace tremolo
