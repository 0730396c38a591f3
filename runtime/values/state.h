// The state of a reduced body.
#pragma once

#include <Eigen/Core>

namespace tremolo {

// q: kg^1/2 m. p: kg^1/2 m/s. Both r long.
struct State {
  Eigen::VectorXd q;
  Eigen::VectorXd p;
};

}  // namespace tremolo
