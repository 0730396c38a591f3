// The ideal pendulum (thesis, figure 9) as one stiff StVK bar. Per unit of mass, for the end point
// x = (x, y) of a bar of length L that hangs from the origin,
//
//     V(x) = (k L^2/8) (|x|^2/L^2 - 1)^2 + g y
//
// is exactly quartic. About the hanging rest, x = (0, -l) with (k/2)(l^2/L^2 - 1) l = g, it is a
// Model of two coordinates: the swing, lambda = g/l, and the stretch, lambda = g/l + k l^2/L^2.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "runtime/integrator.h"

namespace tremolo::known {

// length: L, m. gravity: g, m/s^2. stiffness: k, 1/s^2. angle: at the start, rad from the vertical;
// it starts at rest with the length l
// at which the bar balances the weight along it: (k/2)(l^2/L^2 - 1) l = g cos(angle).
struct Pendulum {
  double length = 1.0;
  double gravity = 9.81;
  double stiffness = 200.0;
  double angle = 1.0;
};

double hanging_length(const Pendulum& pendulum);  // l, m
Model::Pointer pendulum_model(const Pendulum& pendulum);
Eigen::Vector2d pendulum_position(const Pendulum& pendulum, const Eigen::VectorXd& q);  // x, m
State pendulum_start(const Pendulum& pendulum);

// V(x) above, less its value at the hanging rest; m^2/s^2.
double pendulum_potential(const Pendulum& pendulum, const Eigen::Vector2d& x);

// One orbit. first, last: the largest |angle| over the first and the last `swings` periods, rad. If
// H exceeds ten times its start or the solver gives up the run ends there: reached, s, and failure.
struct PendulumRun {
  std::string method;
  double step = 0.0;
  double first = 0.0;
  double last = 0.0;
  double reached = 0.0;
  std::string failure;
  std::vector<double> t, angle, x, y;
};

// The stretch coordinate is the implicit one of the splitting methods. Throws a Failure as
// make_integrator.
PendulumRun run_pendulum(const Pendulum& pendulum, std::string_view method, double step,
                         double duration, double swings);

}  // namespace tremolo::known
