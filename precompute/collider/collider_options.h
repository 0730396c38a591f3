// Options of `tremolo-precompute collider`.
#pragma once

#include <optional>
#include <string>
#include <variant>

namespace tremolo {

struct ColliderOptions {
  std::string surface_path;  // a surface, or a tetrahedral mesh, whose boundary is used
  std::string output_path;
  std::string unit;  // of its coordinates, as for metres_per_unit(); empty: the file's
  bool y_up = false;
  std::optional<int> cells;      // along the longest side; none: enough for kColliderError
  std::optional<double> margin;  // m around the surface; none: kColliderMargin of the longest side
  bool fill_holes = false;
  unsigned threads = 1;
  bool json = false;
  std::string command_line;  // the part that affects the result
};

// Without --cells: the largest error and the margin, relative to the longest side, and the fraction
// of the surface whose walls may be missed.
inline constexpr double kColliderError = 0.005;
inline constexpr double kColliderMissed = 0.002;
inline constexpr double kColliderMargin = 0.05;
// Without --cells: the first number that is tried, and the last.
inline constexpr int kFirstCells = 64;
inline constexpr int kLastCells = 256;

// Parses the words after `collider`. Returns the exit code if the program ends here (the text has
// been printed).
std::variant<ColliderOptions, int> parse_collider_line(int count, char** words);

}  // namespace tremolo
