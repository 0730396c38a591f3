// --start: where a body is at t = 0.
#pragma once

#include <string>

#include "common/result.h"
#include "runtime/integrator.h"
#include "runtime/model.h"
#include "runtime/program/start/start_text.h"

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

}  // namespace tremolo
