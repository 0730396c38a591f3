// The frame of a flying body, computed from all its vertices.
#pragma once

#include <string>

#include <Eigen/Geometry>

#include "precompute/reference/time_integration.h"
#include "precompute/reference/world/world_step.h"

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

// Columns: t (s), kinetic, potential, total, work, dissipated (J); x y z (m) qw qx qy qz, the
// frame; px py pz (kg m/s), lx ly lz (N m s, about the world's origin), the momenta of the whole
// mesh; u<v>x u<v>y u<v>z of the probes, m, along the frame's axes.
std::string world_table_head(const std::vector<VertexId>& probes);

// relative: displacements in the frame, 3n.
std::string world_table_row(const Motion& motion, const WholeFrame& frame,
                            const std::vector<VertexId>& probes, const Field& relative);

}  // namespace tremolo
