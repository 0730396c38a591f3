// Reduced forces as they come in a .cub -> the symmetric tensors of their potential, in any
// coordinates.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "formats/vega/reduced_files.h"

namespace tremolo {

// V = 1/2 q^T quadratic q + C[q,q,q] + Q[q,q,q,q]; unique entries as in common/packed_index.h.
struct ReducedTensors {
  Eigen::MatrixXd quadratic;    // r x r, symmetric
  std::vector<double> cubic;    // C
  std::vector<double> quartic;  // Q
};

// A tensor entry stands in as many rows of the forces as it has different indices; the mean is
// taken. asymmetry: the largest difference of a row from the mean, in parts of the largest entry of
// its tensor: rounding in forces that have a potential.
struct SymmetrisedForces {
  ReducedTensors tensors;
  double asymmetry = 0;
};
SymmetrisedForces symmetrise(const ReducedForces& forces);

// The same energy over q', where q = change q'. change: r x r. O(r^5), memory of r^4/4 numbers.
ReducedTensors change_coordinates(const ReducedTensors& tensors, const Eigen::MatrixXd& change);

// dV/dq at q.
Eigen::VectorXd gradient(const ReducedTensors& tensors, const Eigen::VectorXd& q);

}  // namespace tremolo
