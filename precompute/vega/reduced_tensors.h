// Converts the reduced forces of a .cub file to the symmetric tensors of their potential, and
// transforms these to other coordinates.
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

// A tensor entry occurs in as many rows of the forces as it has distinct indices; the mean is
// taken. asymmetry: largest difference of a row from the mean, relative to the largest entry of the
// tensor; rounding if the forces have a potential.
struct SymmetrisedForces {
  ReducedTensors tensors;
  double asymmetry = 0;
};
SymmetrisedForces symmetrise(const ReducedForces& forces);

// Returns the same energy as a function of q', q = change q'. change: r x r. O(r^5) operations,
// memory for r^4/4 numbers.
ReducedTensors change_coordinates(const ReducedTensors& tensors, const Eigen::MatrixXd& change);

// Returns dV/dq at q.
Eigen::VectorXd gradient(const ReducedTensors& tensors, const Eigen::VectorXd& q);

}  // namespace tremolo
