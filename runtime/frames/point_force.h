// A force in the world on a vertex of a body whose frame moves.
#pragma once

#include <Eigen/Core>

#include "common/load_signal.h"
#include "runtime/values/vertex_rows.h"

namespace tremolo {

// A force along the world's axes on a vertex.
struct PointForce {
  Signal signal;                                    // multiplies the force
  VertexRows place;                                 // the vertex
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // N
  int steps = 0;  // remaining steps if positive; else it acts as long as the signal lasts
  Eigen::VectorXd weights = {};  // of the vertex on the body's bones; empty with one frame
};

}  // namespace tremolo
