// A hand: a spring and a damper from a place of a body to a point that moves.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "formats/tets/tets_file.h"
#include "runtime/tets/elements/tet_model.h"

namespace tremolo {

class TetBody;

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

// A hand at a vertex of the drawn surface of the model's file: its control points and shares; it
// pulls by nothing. vertex: one of the surface's.
TetHand hand_at(const TetModel& model, const TetsSurface& surface, std::size_t vertex);

// Stiffness and damping that suit a place: so stiff that a held body goes four fifths of the hand's
// way under a slow pull, and a free one swings about the hand with 2 Hz; so damped, by half of what
// is critical, that the pull does not ring. Errors (kUsage): the place is fixed.
Status suit_springs(TetBody& body, TetHand& hand);

}  // namespace tremolo
