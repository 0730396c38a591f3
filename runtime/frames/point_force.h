// A force of the world on a vertex of a body whose frame moves.
#pragma once

#include <Eigen/Core>

#include "common/load_signal.h"
#include "runtime/values/vertex_rows.h"

namespace tremolo {

// place: the vertex. weights: with which it hangs on the body's bones; empty with one frame. force:
// N, along the world's axes, times the signal. steps: so many steps more if positive; else as long
// as the signal lasts.
struct PointForce {
  Signal signal;
  VertexRows place;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  int steps = 0;
  Eigen::VectorXd weights = {};
};

}  // namespace tremolo
