// The grammar of --start (start_state.h).
#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

#include "common/result.h"

namespace tremolo {

// "X,Y,Z" -> vector; kUsage otherwise.
Result<Eigen::Vector3d> parse_force(const std::string& text);

inline constexpr const char* kStaticStart = "static";

// WHERE=X,Y,Z: `where` a vertex's id or a selector, `by` m.
struct StartDisplacement {
  std::string where;
  Eigen::Vector3d by;
};
// Nothing if the text has another form.
std::optional<StartDisplacement> start_displacement(const std::string& text);

// FILE.csv[@T]: `time` s; none: the last row.
struct StartRow {
  std::string path;
  std::optional<double> time;
};
// Row of a text that is neither kStaticStart nor a displacement.
StartRow start_row(const std::string& text);

// The file in the text, and the selector in it; empty: none.
std::string file_of_start(const std::string& text);
std::string selector_of_start(const std::string& text);

}  // namespace tremolo
