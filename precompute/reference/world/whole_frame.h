// The frame of a flying body, computed from all its vertices.
#pragma once

#include <Eigen/Geometry>

#include "precompute/reference/world/world_body.h"

namespace tremolo {

// A frame x = position + rotation (X + u), and the momenta: linear, kg m/s; angular, about the
// world's origin, N m s.
struct WholeFrame {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d linear_momentum = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_momentum = Eigen::Vector3d::Zero();
};

// displacement, velocity: in the world, 3n. For a body with a support the frame is the support's
// pose. The frame of a flying body moves with the centre of mass; its rotation is the polar factor
// of int rho (x - c) (X - C)^T, the rotation that fits the masses best.
WholeFrame whole_frame(const WorldBody& world, double time, const Field& displacement,
                       const Field& velocity);

// u of all vertices along the frame's axes, m, 3n.
Field displacement_in(const WholeFrame& frame, const WorldBody& world, const Field& displacement);

}  // namespace tremolo
