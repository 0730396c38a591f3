// The state of a reduced body.
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

}  // namespace tremolo
