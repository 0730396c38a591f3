// Which mode of a model a measured frequency belongs to.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "precompute/sensitivity/measurements.h"

namespace tremolo {

// The mode, from 0, of each row. hertz: the model's frequencies, ascending. Rows that name a mode
// have it. The others, by ascending frequency, take ascending modes of those left over, so that the
// sum of squares of the logarithms of measured over computed frequencies is least: a measured list
// may have gaps, and no mode is taken twice. Of several modes with one frequency a row takes the
// first that is left; for a fit they are the same (material_fit.h). Errors (kContent): a mode or
// more rows than the model has modes.
Result<std::vector<int>> match_modes(const std::vector<MeasuredMode>& rows,
                                     const Eigen::VectorXd& hertz);

}  // namespace tremolo
