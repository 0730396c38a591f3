// Which edges of a body are quadratic, and what happens to its motion when one changes.
//
// A linear edge's control point is kept at the mean of its ends. What the quadratic mesh would pull
// it with, the residual r_ab of its row, says where it would go: by |r_ab| / (g_a m_ab + k_ab),
// with m_ab its mass and k_ab a third of the trace of its own stiffness at rest. A quadratic edge's
// distance from the mean is known, and where it will be a step later. An edge becomes quadratic
// where the first exceeds `upper` times its length at rest, linear where the second is below
// `lower` times it, and keeps a degree for `least_steps` steps. With infinitely many candidates
// right at a threshold the body would flicker; lower < upper and the least time prevent it.
//
// When edges become linear, x and v become E (E^T M E)^-1 E^T M x and likewise v, E the map from
// free control points to all: the nearest motion in kinetic energy that the linear edges can make,
// with the same linear momentum and centre, and no more kinetic energy (mass_projection.h). What x
// moved changes the angular momentum; of a body that is not held a rigid rate of turn restores it.
// When edges become quadratic nothing moves.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/tets/elements/tet_system.h"
#include "runtime/tets/solve/tet_stage.h"

namespace tremolo {

enum class DegreeKind { kLinear, kQuadratic, kAdaptive };
Result<DegreeKind> parse_degree(std::string_view name);  // "linear", "quadratic", "adaptive"

// upper, lower: of an edge's length, 0 < lower <= upper. every: steps between two looks.
struct DegreeOptions {
  DegreeKind kind = DegreeKind::kQuadratic;
  double upper = 0.001;
  double lower = 0.0004;
  int least_steps = 10;
  int every = 1;
};
Status check(const DegreeOptions& options);

class DegreeChoice {
 public:
  DegreeChoice(const TetModel& model, const DegreeOptions& options);

  // The degrees to begin with.
  std::vector<std::uint8_t> first_degrees() const;

  // residual: of the fully quadratic equation, not folded, at the end of a step; rate: g_a. Returns
  // the degrees wanted now, as many as edges; valid until the next call.
  std::span<const std::uint8_t> choose(const TetSystem& system, const TetMotion& motion,
                                       const Eigen::VectorXd& residual, double rate, double h);
  std::size_t changed() const { return changed_; }

 private:
  DegreeOptions options_;
  std::vector<double> stiffness_, mass_;  // k_ab, m_ab
  std::vector<int> age_;
  std::vector<std::uint8_t> wanted_;
  std::size_t changed_ = 0;
};

}  // namespace tremolo
