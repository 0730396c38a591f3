// A small strongly nonlinear solid: three unit masses between two walls on four bars, each a
// one-dimensional StVK solid of length 1 with the energy 1/2 k (d + d^2/2)^2 at the extension d.
// Its coordinates are its three modes, of 36, 70 and 111 Hz (at 3 ms h omega is 0.69, 1.3 and
// 2.1); at the state below its bars are stretched by 0.3 and pressed by 0.4.
#pragma once

#include <Eigen/Core>

#include "runtime/integrator.h"

namespace tremolo::known {

struct SpringChain {
  Model::Pointer model;
  Eigen::Matrix3d modes;  // displacements u = modes q; orthogonal
};

SpringChain spring_chain();

// The energy written out, J. u: displacements, m.
double spring_chain_energy(const Eigen::Vector3d& u);

// scale: 1 is the strongly nonlinear state; smaller ones are nearer to the linear model.
State spring_chain_state(const SpringChain& chain, double scale = 1.0);

}  // namespace tremolo::known
