// Rows of U for a vertex, in the coordinates of a model.
#pragma once

#include <Eigen/Core>

#include "common/state_stream.h"

namespace tremolo {

// One vertex: rest position (m) and its three rows of U, 3 x r, kg^-1/2, row by row in memory.
struct VertexRows {
  Eigen::Vector3d rest = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> rows;
};

// modes: the number r of columns that restored rows must have.
inline void carry(StateStream& stream, VertexRows& place, Eigen::Index modes) {
  stream(place.rest);
  Eigen::Matrix<double, 3, Eigen::Dynamic> columns = place.rows;
  stream.sized(columns);
  place.rows = columns;
  stream.require(place.rows.cols() == modes && place.rows.allFinite() && place.rest.allFinite());
}

}  // namespace tremolo
