// A support that shakes and rotates, as a function of time, for tests of bodies that are moved.
#pragma once

#include <cmath>
#include <fstream>
#include <iomanip>
#include <numbers>
#include <string>

#include "runtime/bodies/reduced/frames/driven_frame.h"

namespace tremolo::testing {

// It is at rest at t = 0 with five derivatives. shake: m, at `frequency` (Hz). spin: rad/s, which
// it has from 0.5 s on.
struct GivenMotion {
  Eigen::Vector3d shake = Eigen::Vector3d::Zero();
  double frequency = 1.0;
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();

  Pose at(double time) const {
    if (time <= 0) return {};
    const double rise = 1.0 - std::exp(-std::pow(time / 0.2, 4));
    const double sine = std::sin(2.0 * std::numbers::pi * frequency * time);
    constexpr double kRamp = 0.5;  // s
    const double x = time / kRamp;
    // The integral of 10 x^3 - 15 x^4 + 6 x^5 up to the ramp's end, then of 1.
    const double turned =
        x >= 1 ? time - 0.5 * kRamp
               : kRamp * (std::pow(x, 6) - 3.0 * std::pow(x, 5) + 2.5 * std::pow(x, 4));
    return {rise * sine * sine * sine * shake, turn_by(turned * spin)};
  }

  // Motion of the step from `time` on.
  FrameMotion in_step(double time, double step) const {
    return motion_between(at(time - step), at(time), at(time + step), at(time + 2.0 * step), step);
  }

  // As --support-motion of tremolo-precompute reads it.
  void write(const std::string& path, double duration, double step) const {
    std::ofstream file(path);
    file << std::setprecision(17) << "t,x,y,z,qw,qx,qy,qz\n";
    for (int i = 0; i * step <= duration + 2.0 * step; ++i) {
      const Pose pose = at(i * step);
      const Eigen::Quaterniond& q = pose.rotation;
      file << i * step;
      for (const double value :
           {pose.position.x(), pose.position.y(), pose.position.z(), q.w(), q.x(), q.y(), q.z()})
        file << ',' << value;
      file << '\n';
    }
  }
};

}  // namespace tremolo::testing
