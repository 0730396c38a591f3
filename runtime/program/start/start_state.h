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
//   static           standing still under `force`, what the loads are at t = 0
//   WHERE=X,Y,Z      WHERE, a vertex's id or a selector, displaced by X,Y,Z (m, of several vertices
//                    their mean) and everything else as the energy wants it; let go at t = 0
//   FILE.csv[@T]     the row of a run's CSV nearest to T (s), the last one without; it needs q and
//   p
//                    of all coordinates. Loads and time begin anew
// force: r. Errors: kUsage for a malformed text and what selectors refuse; kSystem for a file that
// cannot be read; kContent for a row that is no state of this model; kSolver where there is no such
// shape.
Result<State> start_state(const std::string& text, const Model& model,
                          const Eigen::VectorXd& force);

}  // namespace tremolo
