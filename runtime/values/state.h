// The state of a reduced body.
#pragma once

#include <Eigen/Core>

#include "common/state_stream.h"

namespace tremolo {

// q: kg^1/2 m. p: kg^1/2 m/s. Both r long.
struct State {
  Eigen::VectorXd q;
  Eigen::VectorXd p;
};

inline void carry(StateStream& stream, State& state) {
  stream(state.q, state.p);
}

}  // namespace tremolo
