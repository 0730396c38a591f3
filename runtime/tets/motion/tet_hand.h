// A hand: a spring and a damper from a place of a body to a point that moves.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "runtime/tets/elements/tet_model.h"

namespace tremolo {

// With x = sum_I B_I x_I the place, v its velocity, p the point when a step takes its forces (at
// its end; of midpoint in its middle) and w the point's velocity: f = k (p - x) + d (w - v) on the
// place. A step that is cut has them so in each part. nodes: the control points of an element;
// shares: B_I. stiffness: k, N/m. damping: d, N s/m. point: p, m. velocity: w, m/s.
struct TetHand {
  std::array<std::uint32_t, kMostNodes> nodes{};
  std::array<double, kMostNodes> shares{};
  double stiffness = 0.0;
  double damping = 0.0;
  Eigen::Vector3d point = Eigen::Vector3d::Zero(), velocity = Eigen::Vector3d::Zero();

  // The sum of the shares of a vector of all control points.
  Eigen::Vector3d of(const Eigen::VectorXd& x) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < nodes.size(); ++k)
      sum += shares[k] * x.segment<3>(3 * static_cast<Eigen::Index>(nodes[k]));
    return sum;
  }
};

}  // namespace tremolo
