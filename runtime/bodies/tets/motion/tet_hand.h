// A grab: a spring and a damper from a point of a body to a moving point.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "formats/tets/tets_file.h"
#include "runtime/bodies/tets/elements/tet_model.h"

namespace tremolo {

class TetBody;

// The force on the grabbed point is f = k (p - x) + d (w - v). x = sum_I B_I x_I is its position
// and v its velocity; p and w are those of the moving point when a step evaluates its forces (at
// its end; for midpoint in its middle). Each part of a subdivided step uses the same p and w.
struct TetHand {
  std::array<std::uint32_t, kMostNodes> nodes{};  // the control points of an element
  std::array<double, kMostNodes> shares{};        // B_I
  double stiffness = 0.0;                         // k, N/m
  double damping = 0.0;                           // d, N s/m
  // p, m, and w, m/s.
  Eigen::Vector3d point = Eigen::Vector3d::Zero(), velocity = Eigen::Vector3d::Zero();

  // The weighted sum of a vector of all control points.
  Eigen::Vector3d of(const Eigen::VectorXd& x) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < nodes.size(); ++k)
      sum += shares[k] * x.segment<3>(3 * static_cast<Eigen::Index>(nodes[k]));
    return sum;
  }
};

// Makes a grab at a vertex of the drawn surface of the model's file: its control points and
// weights, without stiffness. vertex: one of the surface's.
TetHand hand_at(const TetModel& model, const TetsSurface& surface, std::size_t vertex);

// Sets a stiffness and damping that suit the grabbed point. A supported body moves four fifths of
// the grab's path under a slow pull; a free one oscillates about the grab with 2 Hz. Half of
// critical damping prevents ringing. Error (kUsage): the point is fixed.
Status suit_springs(TetBody& body, TetHand& hand);

}  // namespace tremolo
