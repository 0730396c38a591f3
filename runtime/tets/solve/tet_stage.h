// One implicit step of a second-order system as one nonlinear equation. With the unknown way d from
// x_v to the place where forces are taken, all methods here are
//   M g^2 (d - d_a) = F(x_v + d, g d),
// and differ in what is known (h the step, index 0 its beginning, -1 the one before):
//   implicit-euler  g = 1/h     x_v = x_0              d_a = h v_0              x_1 = x_0 + d
//                                                                               v_1 = g d
//   midpoint        g = 2/h     x_v = x_0              d_a = h/2 v_0            x_1 = x_0 + 2 d
//                                                                               v_1 = 2 g d - v_0
//   newmark (1/4)   g = 2/h     x_v = x_0 + h/2 v_0    d_a = h/2 v_0 + h^2/4 a_0
//                                                      x_1 = x_v + d   v_1 = g d
//                                                      a_1 = g^2 (d - d_a)
//   bdf2            g = 3/(2h)  x_v = (4 x_0 - x_-1)/3  d_a = (4 v_0 - v_-1)/(3 g)
//                                                      x_1 = x_v + d   v_1 = g d
// bdf2 takes its first step by implicit-euler. That d is small keeps the digits of velocities
// wherever in space the body is.
#pragma once

#include <string_view>

#include <Eigen/Core>

#include "common/result.h"

namespace tremolo {

enum class TetMethod { kImplicitEuler, kMidpoint, kNewmark, kBdf2 };

// "implicit-euler", "midpoint", "newmark", "bdf2". Errors (kUsage): another name.
Result<TetMethod> parse_tet_method(std::string_view name);
const char* tet_method_name(TetMethod method);

// Places, velocities, and the accelerations of newmark, 3 a control point.
struct TetMotion {
  Eigen::VectorXd x, v, a;
};

// method: the one that is taken. rate: g, 1/s.
struct TetStage {
  TetMethod method = TetMethod::kImplicitEuler;
  double rate = 0.0;
  Eigen::VectorXd from, inertial;  // x_v, d_a
};

// before: of the step before, for bdf2; null: there is none. h: s. Allocates nothing once the
// vectors of `stage` have their size.
void begin_stage(TetMethod method, double h, const TetMotion& now, const TetMotion* before,
                 TetStage& stage);

// now: becomes the end of the step whose d has been found; before: where it began.
void end_stage(const TetStage& stage, const Eigen::VectorXd& d, TetMotion& now, TetMotion& before);

}  // namespace tremolo
