// The two momenta of moving bodies.
#pragma once

#include <Eigen/Core>

namespace tremolo {

// Momenta of a whole body, or of several: linear, kg m/s; angular, N m s, about the world's origin.
struct Momenta {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();
};

}  // namespace tremolo
