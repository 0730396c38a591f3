// Chooses the coordinates that a splitting method steps explicitly (thesis 4.2).
//
// lambda ascends, so a split is a count: the leading `low` coordinates are explicit. The explicit
// half is linearly stable iff h omega < 2, that is f < 1/(pi h). The thesis's f < 1/h (4.2.1) is
// not a stability limit: with modes between the two limits the orbit explodes.
#pragma once

#include <string_view>

#include <Eigen/Core>

#include "common/result.h"

namespace tremolo {

enum class SplitRule {
  kDefault,  // explicit iff h omega_i < 2 safety
  kThesis,   // explicit iff f_i < 1/h
  kCount,    // the first `count`
};

// Options of a split.
struct SplitOptions {
  SplitRule rule = SplitRule::kDefault;
  int count = 0;
  // In (0, 1]. Deformation stiffens a solid, so the usual 0.9 leaves some margin. At 1 the
  // slightest stiffening of the highest explicit coordinate makes it unstable.
  double safety = 0.9;
};

struct Split {
  Eigen::Index low = 0;
  Eigen::Index high = 0;
};

// step: s. Errors (kUsage): a count outside [0, r], a safety outside (0, 1].
Result<Split> choose_split(const Eigen::VectorXd& lambda, double step, const SplitOptions& options);

// "default", "thesis" or a count; kUsage otherwise. safety keeps its default.
Result<SplitOptions> parse_split(std::string_view text);

}  // namespace tremolo
