#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "runtime/bodies/cloth/cloth_parts.h"
#include "runtime/io/scenes/nodal_readers.h"
#include "runtime/io/scenes/part_readers.h"

namespace tremolo {
namespace {

// Rows and columns of a grid, ends included.
struct GridPart {
  std::size_t first_row, last_row, first_column, last_column;
};

std::optional<GridPart> grid_part(const ClothGrid& grid, std::string_view word) {
  GridPart part{0, grid.rows - 1, 0, grid.columns - 1};
  const std::size_t dash = word.find('-');
  const std::string_view ends[] = {word.substr(0, dash),
                                   dash == std::string_view::npos ? "" : word.substr(dash + 1)};
  for (const std::string_view end : ends) {
    if (end == "top")
      part.first_row = part.last_row;
    else if (end == "bottom")
      part.last_row = 0;
    else if (end == "left")
      part.last_column = 0;
    else if (end == "right")
      part.first_column = part.last_column;
    else if (!end.empty())
      return std::nullopt;
  }
  // "top-bottom" and "-" are not valid.
  const bool rows = ends[0] == "top" || ends[0] == "bottom";
  const bool columns = ends[1] == "left" || ends[1] == "right";
  if (dash == std::string_view::npos ? word.empty() : !(rows && columns)) return std::nullopt;
  return part;
}

std::optional<double> whole_text(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

// "X,Y,Z"
std::optional<Eigen::Vector3d> point_of_text(std::string_view text) {
  Eigen::Vector3d point;
  for (int k = 0; k < 3; ++k) {
    const std::size_t comma = text.find(',');
    if ((comma == std::string_view::npos) != (k == 2)) return std::nullopt;
    const auto value = whole_text(text.substr(0, comma));
    if (!value) return std::nullopt;
    point[k] = *value;
    text = k == 2 ? "" : text.substr(comma + 1);
  }
  return point;
}

// The particle that is nearest to the point at rest.
void add_nearest(TomlKeys& keys, const SceneCloth& cloth, const Eigen::Vector3d& point,
                 std::vector<std::size_t>& particles) {
  const Result<ClothParts> parts = make_cloth_parts(cloth);
  if (!parts) return keys.fail(parts.error());
  const Eigen::Map<const Eigen::Matrix3Xd> places(parts->x.data(), 3, parts->x.size() / 3);
  Eigen::Index nearest = 0;
  (places.colwise() - point).colwise().squaredNorm().minCoeff(&nearest);
  particles.push_back(parts->vertex_of_particle(static_cast<std::size_t>(nearest)));
}

void add_part(const ClothGrid& grid, const GridPart& part, std::vector<std::size_t>& particles) {
  for (std::size_t row = part.first_row; row <= part.last_row; ++row)
    for (std::size_t column = part.first_column; column <= part.last_column; ++column)
      particles.push_back(grid_particle(grid, row, column));
}

// Adds the particles of one place of the key.
void add_place(TomlKeys& keys, const char* key, const SceneCloth& cloth, const std::string& place,
               std::vector<std::size_t>& particles) {
  const bool is_grid = cloth.file.empty();
  if (place.starts_with("near:")) {
    const auto point = point_of_text(std::string_view(place).substr(5));
    if (!point) return keys.fail(key, "'" + place + "': a place is near:X,Y,Z in m");
    return add_nearest(keys, cloth, *point, particles);
  }
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(place.data(), place.data() + place.size(), number);
  if (error == std::errc{} && end == place.data() + place.size()) {
    if (is_grid && number >= cloth.grid.rows * cloth.grid.columns)
      return keys.fail(key, "there is no particle " + place + ": the grid has " +
                                std::to_string(cloth.grid.rows * cloth.grid.columns) +
                                ", counted from 0");
    return particles.push_back(number);
  }
  if (is_grid && place == "corners") {
    for (const char* corner : {"bottom-left", "bottom-right", "top-left", "top-right"})
      add_part(cloth.grid, *grid_part(cloth.grid, corner), particles);
    return;
  }
  const auto part = is_grid ? grid_part(cloth.grid, place) : std::nullopt;
  if (part) return add_part(cloth.grid, *part, particles);
  keys.fail(key,
            "'" + place + "' is no place of particles: " +
                (is_grid ? "a number, near:X,Y,Z, corners, top, bottom, left, right, top-left, "
                           "top-right, bottom-left or bottom-right"
                         : "of a mesh a number or near:X,Y,Z"));
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
