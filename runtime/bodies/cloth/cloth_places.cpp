#include "runtime/bodies/cloth/cloth_places.h"

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "common/text.h"

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
  const auto [end, error] = read_decimal(text.data(), text.data() + text.size(), value);
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
std::size_t nearest_to(const SceneCloth& cloth, const ClothParts& parts,
                       const Eigen::Vector3d& point) {
  Eigen::Matrix3Xd places =
      Eigen::Map<const Eigen::Matrix3Xd>(parts.x.data(), 3, parts.x.size() / 3);
  if (cloth.named_at)
    for (Eigen::Index i = 0; i < places.cols(); ++i) places.col(i) = cloth.named(places.col(i));
  Eigen::Index nearest = 0;
  (places.colwise() - point).colwise().squaredNorm().minCoeff(&nearest);
  return parts.vertex_of_particle(static_cast<std::size_t>(nearest));
}

void add_part(const ClothGrid& grid, const GridPart& part, std::vector<std::size_t>& particles) {
  for (std::size_t row = part.first_row; row <= part.last_row; ++row)
    for (std::size_t column = part.first_column; column <= part.last_column; ++column)
      particles.push_back(grid_particle(grid, row, column));
}

}  // namespace

Status add_cloth_place(const SceneCloth& cloth, const ClothParts* parts, const std::string& place,
                       std::vector<std::size_t>& particles) {
  const bool is_grid = cloth.file.empty();
  if (place.starts_with("near:")) {
    const auto point = point_of_text(std::string_view(place).substr(5));
    if (!point) return content_error("'" + place + "': a place is near:X,Y,Z in m");
    particles.push_back(nearest_to(cloth, *parts, *point));
    return Success{};
  }
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(place.data(), place.data() + place.size(), number);
  if (error == std::errc{} && end == place.data() + place.size()) {
    if (is_grid && number >= cloth.grid.rows * cloth.grid.columns)
      return content_error("there is no particle " + place + ": the grid has " +
                           std::to_string(cloth.grid.rows * cloth.grid.columns) +
                           ", counted from 0");
    particles.push_back(number);
    return Success{};
  }
  if (is_grid && place == "corners") {
    for (const char* corner : {"bottom-left", "bottom-right", "top-left", "top-right"})
      add_part(cloth.grid, *grid_part(cloth.grid, corner), particles);
    return Success{};
  }
  const auto part = is_grid ? grid_part(cloth.grid, place) : std::nullopt;
  if (!part)
    return content_error("'" + place + "' is no place of particles: " +
                         (is_grid ? "a number, near:X,Y,Z, corners, top, bottom, left, right, "
                                    "top-left, top-right, bottom-left or bottom-right"
                                  : "of a mesh a number or near:X,Y,Z"));
  add_part(cloth.grid, *part, particles);
  return Success{};
}

}  // namespace tremolo
