// Chooses the quadratic edges of a body, and projects its motion when they change.
//
// A linear edge's control point is fixed at the mean of its ends. The residual r_ab of its row is
// the force that the quadratic mesh would apply to it. It gives the displacement |r_ab| / s and the
// energy |r_ab|^2 / (2 s) that this would release, with s = g_a m_ab + k_ab: m_ab its mass, k_ab a
// third of the trace of its own stiffness at rest. This is the error estimate of hierarchical bases
// (Bank and Weiser 1985). For a quadratic edge the distance d from the mean is known, now and a
// step later, and so is the energy s d^2 / 2 that keeping it there would cost.
//
// An edge becomes quadratic where that energy is above an equal part of `error` times the energy
// that deforms the body: elastic, and kinetic relative to the nearest rigid motion. The energy that
// linear edges keep from being released is then below `error` of it; so, approximately, is the
// excess stiffness of the body, however much it bends. An edge becomes linear below kCalmer of
// that.
//
// With `upper`, an edge must also move by more than `upper` times its length at rest to become
// quadratic, and becomes linear where it moves by less than `lower` times: smaller displacements
// are not visible, whatever their effect on the stiffness. A degree is kept for `least_steps`
// steps. With many edges at a threshold the body would otherwise flicker; two thresholds and the
// least time prevent it.
//
// When edges become linear, x and v become E (E^T M E)^-1 E^T M x and the same of v, with E the map
// from free control points to all. This is the nearest motion in kinetic energy that the linear
// edges allow, with the same linear momentum and centre, and no more kinetic energy
// (mass_projection.h). The displacement of x changes the angular momentum; for a body without
// support a rigid rotation rate restores it. When edges become quadratic nothing moves.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/bodies/tets/elements/tet_system.h"
#include "runtime/bodies/tets/solve/tet_stage.h"

namespace tremolo {

enum class DegreeKind { kLinear, kQuadratic, kAdaptive };
Result<DegreeKind> parse_degree(std::string_view name);  // "linear", "quadratic", "adaptive"

// Options of the choice.
struct DegreeOptions {
  DegreeKind kind = DegreeKind::kQuadratic;
  // Fraction of the energy that deforms the body, 0 to 1; 0: any error is too large, and `upper`
  // decides.
  double error = 0.05;
  // Fractions of an edge's length, 0 <= lower <= upper; 0: `error` alone decides.
  double upper = 0.0;
  double lower = 0.0;
  int least_steps = 10;
  // Number of steps after which edges may become linear again, which costs a solve with the mass
  // matrix. They become quadratic after any step, which costs nothing.
  int every = 5;
};
Status check(const DegreeOptions& options);

// Values at the end of a step from which degrees are chosen.
struct DegreeMeasure {
  // Of the fully quadratic equation, not condensed, N.
  const Eigen::VectorXd& residual;
  double noise = 0.0;   // smaller rows of the residual are left by the solve, N
  double energy = 0.0;  // energy that deforms the body, J
  double rate = 0.0;    // g_a, 1/s^2
  double h = 0.0;       // of the step, s
  bool calm = true;     // edges may become linear
};

class DegreeChoice {
 public:
  DegreeChoice(const TetModel& model, const DegreeOptions& options);

  // The degrees at the start.
  std::vector<std::uint8_t> first_degrees() const;

  // Returns the degrees for the present state, one per edge; valid until the next call.
  std::span<const std::uint8_t> choose(const TetSystem& system, const TetMotion& motion,
                                       const DegreeMeasure& measure);
  std::size_t changed() const { return changed_; }
  // Saves or restores how long each edge has had its degree.
  void carry(StateStream& stream) {
    stream(age_);
    for (const int age : age_) stream.require(age >= 0 && age < kOldest);
  }

 private:
  static constexpr int kOldest = 1 << 30;  // no run has as many steps

  DegreeOptions options_;
  std::vector<double> stiffness_, mass_;  // k_ab, m_ab
  std::vector<int> age_;
  std::vector<std::uint8_t> wanted_;
  std::size_t changed_ = 0;
};

}  // namespace tremolo
