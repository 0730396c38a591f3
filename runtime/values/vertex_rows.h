// What a vertex does in the coordinates of a model.
#pragma once

#include <Eigen/Core>

namespace tremolo {

// One vertex: rest position (m) and its three rows of U, 3 x r, kg^-1/2.
struct VertexRows {
  Eigen::Vector3d rest;
  Eigen::Matrix<double, 3, Eigen::Dynamic> rows;
};

}  // namespace tremolo
