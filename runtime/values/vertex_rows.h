// What a vertex does in the coordinates of a model.
#pragma once

#include <Eigen/Core>

#include "common/state_stream.h"

namespace tremolo {

// One vertex: rest position (m) and its three rows of U, 3 x r, kg^-1/2.
struct VertexRows {
  Eigen::Vector3d rest = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 3, Eigen::Dynamic> rows;
};

// modes: r, which what is read must have.
inline void carry(StateStream& stream, VertexRows& place, Eigen::Index modes) {
  stream(place.rest);
  stream.sized(place.rows);
  stream.require(place.rows.cols() == modes && place.rows.allFinite() && place.rest.allFinite());
}

}  // namespace tremolo
