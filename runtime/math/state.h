// Values that the parts of the engine pass to each other: states, momenta, rows of vertices.
#pragma once

#include <Eigen/Core>

#include "common/state_stream.h"

namespace tremolo {

// A state of r coordinates.
struct State {
  Eigen::VectorXd q;  // kg^1/2 m, r
  Eigen::VectorXd p;  // kg^1/2 m/s, r
};

inline void carry(StateStream& stream, State& state) {
  stream(state.q, state.p);
}

// The two momenta of moving bodies. Momenta of a whole body, or of several: linear, kg m/s;
// angular, N m s, about the world's origin.
struct Momenta {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();
};

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
