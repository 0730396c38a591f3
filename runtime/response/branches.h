// Curves that a response curve leads to: its folds over the load's size, and the branches that
// cross it at branch points.
#pragma once

#include "runtime/response/response.h"

namespace tremolo {

// Follows the fold `fold` of the response curve of the request over the factor of its periodic
// force (CurvePoint::load; 1 at `fold`), until the factor reaches `to_load`, which may be below or
// above 1, or until it is 1 again behind a cusp, where two folds meet (both kDone). The cusps are
// its kFold bifurcations. No stability is computed: a fold has a multiplier at +1. Errors: kContent
// for a factor that is not positive; kSolver if the fold is not one of the request's.
Result<MotionCurve> fold_curve(const VibratingSystem& system, const ResponseRequest& request,
                               const CurvePoint& fold, double to_load, const CurveOptions& options);

// The branch that crosses the response curve `first` at its branch point `branch`, from there until
// it leaves the range of the request or meets `first` again (both kDone), or ends. sign: 1 or -1,
// its two directions; of a symmetric body each is the mirror image of the other. Errors: kSolver if
// no branch is found there.
Result<MotionCurve> crossing_branch(const VibratingSystem& system, const ResponseRequest& request,
                                    const MotionCurve& first, const CurvePoint& branch, int sign,
                                    const CurveOptions& options);

}  // namespace tremolo
