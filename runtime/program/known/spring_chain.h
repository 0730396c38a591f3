// A small strongly nonlinear solid: three unit masses between two walls on four bars, each a
// one-dimensional StVK solid of length 1 with the energy 1/2 k (d + d^2/2)^2 at the extension d.
// Its coordinates are its three modes, of about 25, 64 and 105 Hz: at 3 ms h omega is 0.5, 1.2 and
// 2.0, at the state below its bars are stretched and pressed by up to a half.
#pragma once

#include <Eigen/Core>

#include "runtime/integrators/integrator.h"

namespace tremolo::known {

struct SpringChain {
  Model::Pointer model;
  Eigen::Matrix3d modes;  // displacements u = modes q; orthogonal
};

Result<SpringChain> spring_chain();

// The energy written out, J. u: displacements, m.
double spring_chain_energy(const Eigen::Vector3d& u);

// scale: 1 is the strongly nonlinear state; smaller ones are nearer to the linear model.
State spring_chain_state(const SpringChain& chain, double scale = 1.0);

}  // namespace tremolo::known
