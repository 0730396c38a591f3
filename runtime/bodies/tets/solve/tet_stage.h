// One implicit step of a second-order system as one nonlinear equation. The unknown d is the
// displacement from x_v to the position at which forces are evaluated. All methods here are
//   M g^2 (d - d_a) = F(x_v + d, g d),
// and differ in the known values (h: the step; index 0: its start, -1: the step before):
//   implicit-euler  g = 1/h     x_v = x_0              d_a = h v_0              x_1 = x_0 + d
//                                                                               v_1 = g d
//   midpoint        g = 2/h     x_v = x_0              d_a = h/2 v_0            x_1 = x_0 + 2 d
//                                                                               v_1 = 2 g d - v_0
//   newmark (1/4)   g = 2/h     x_v = x_0 + h/2 v_0    d_a = h/2 v_0 + h^2/4 a_0
//                                                      x_1 = x_v + d   v_1 = g d
//                                                      a_1 = g^2 (d - d_a)
//   bdf2            g = 3/(2h)  x_v = (4 x_0 - x_-1)/3  d_a = (4 v_0 - v_-1)/(3 g)
//                                                      x_1 = x_v + d   v_1 = g d
// bdf2 takes its first step by implicit-euler. Because d is small, velocities keep their digits at
// any distance from the origin.
#pragma once

#include <string_view>

#include <Eigen/Core>

#include "common/result.h"

namespace tremolo {

enum class TetMethod { kImplicitEuler, kMidpoint, kNewmark, kBdf2 };

// "implicit-euler", "midpoint", "newmark", "bdf2". Errors (kUsage): another name.
Result<TetMethod> parse_tet_method(std::string_view name);
const char* tet_method_name(TetMethod method);

// Positions, velocities, and the accelerations of newmark, 3 per control point.
struct TetMotion {
  Eigen::VectorXd x, v, a;
};

// The equation of a stage.
struct TetStage {
  TetMethod method = TetMethod::kImplicitEuler;  // in use
  double rate = 0.0;                             // g, 1/s
  Eigen::VectorXd from, inertial;                // x_v, d_a
};

// before: of the step before, for bdf2; null: there is none. h: s. Allocates nothing once the
// vectors of `stage` have their size.
void begin_stage(TetMethod method, double h, const TetMotion& now, const TetMotion* before,
                 TetStage& stage);

// Sets now to the end of the step whose d has been found, and before to its start.
void end_stage(const TetStage& stage, const Eigen::VectorXd& d, TetMotion& now, TetMotion& before);

}  // namespace tremolo
