// --start: where a body is at t = 0.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/integrator.h"
#include "runtime/model.h"

namespace tremolo {

// text:
//   (empty)          at rest in the rest shape
//   static           the equilibrium under `force`, the loads at t = 0
//   WHERE=X,Y,Z      WHERE, a vertex's id or a selector, is displaced by X,Y,Z (m; the mean of
//                    several vertices), the rest follows by least energy; released at t = 0
//   FILE.csv[@T]     the row of a run's CSV nearest to T (s), without T the last one; it needs q
//                    and p of all coordinates. Loads and time start from zero
// force: r. Errors: kUsage for a malformed text and errors of selectors; kSystem for a file that
// cannot be read; kContent for a row that is not a state of this model; kSolver if no such shape
// exists.
Result<State> start_state(const std::string& text, const Model& model,
                          const Eigen::VectorXd& force);

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

// Reads a state from the CSV of a run. q and p of the row nearest to `time` (s), or of the last
// one. text: the contents of the file; a last line without a line end may be cut off and is
// ignored. path: for errors. modes: the required number of columns q0 ... and p0 .... Errors:
// kContent with the line.
Result<State> parse_state_row(std::string_view text, const std::string& path,
                              std::optional<double> time, Eigen::Index modes);

}  // namespace tremolo
