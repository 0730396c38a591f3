// Which edges of a body are quadratic, and what happens to its motion when one changes.
//
// A linear edge's control point is kept at the mean of its ends. The residual r_ab of its row, with
// which the quadratic mesh would pull at it, says where it would go, by |r_ab| / s, and how much
// energy that would set free, |r_ab|^2 / (2 s), with s = g_a m_ab + k_ab: m_ab its mass, k_ab a
// third of the trace of its own stiffness at rest. This is the error estimate of hierarchical bases
// (Bank and Weiser 1985). Of a quadratic edge the distance d from the mean is known, now and a step
// later, and the energy s d^2 / 2 that it would cost to keep it there.
//
// An edge becomes quadratic where that energy is above an equal part of `error` times the energy
// that deforms the body: elastic, and kinetic relative to the nearest rigid motion. The energy that
// linear edges keep from being set free is then below `error` of it, and so, about, is what the
// body is too stiff by, however little or much it bends. It becomes linear below kCalmer of that.
// Where `upper` is given, an edge also has to go by more than `upper` times its length at rest to
// become quadratic, and becomes linear where it goes by less than `lower` times: smaller ways are
// not seen, whatever they do to the stiffness. A degree is kept for `least_steps` steps. With
// infinitely many candidates right at a threshold the body would flicker; two thresholds and the
// least time prevent it.
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

// error: of the energy that deforms the body, 0 to 1; 0: any error is too large, `upper` decides.
// upper, lower: of an edge's length, 0 <= lower <= upper; 0: `error` alone decides. every: steps
// after which edges may become linear again, which costs a solve with the mass matrix; they become
// quadratic after any step, which costs nothing.
struct DegreeOptions {
  DegreeKind kind = DegreeKind::kQuadratic;
  double error = 0.05;
  double upper = 0.0;
  double lower = 0.0;
  int least_steps = 10;
  int every = 5;
};
Status check(const DegreeOptions& options);

// What a body is judged by, at the end of a step. residual: of the fully quadratic equation, not
// folded, N. noise: smaller rows of it are what the solution left, N. energy: that deforms the
// body, J. rate: g_a, 1/s^2. h: of the step, s. calm: edges may become linear.
struct DegreeMeasure {
  const Eigen::VectorXd& residual;
  double noise = 0.0;
  double energy = 0.0;
  double rate = 0.0;
  double h = 0.0;
  bool calm = true;
};

class DegreeChoice {
 public:
  DegreeChoice(const TetModel& model, const DegreeOptions& options);

  // The degrees to begin with.
  std::vector<std::uint8_t> first_degrees() const;

  // Returns the degrees wanted now, as many as edges; valid until the next call.
  std::span<const std::uint8_t> choose(const TetSystem& system, const TetMotion& motion,
                                       const DegreeMeasure& measure);
  std::size_t changed() const { return changed_; }

 private:
  DegreeOptions options_;
  std::vector<double> stiffness_, mass_;  // k_ab, m_ab
  std::vector<int> age_;
  std::vector<std::uint8_t> wanted_;
  std::size_t changed_ = 0;
};

}  // namespace tremolo
