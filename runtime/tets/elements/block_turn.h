// Rotates blocks of a symmetric element matrix from the element's frame into space.
#pragma once

#include <span>

#include <Eigen/Core>

namespace tremolo {

// out_k = factor R in_k R^T for all blocks of `in`; out may be in. Allocates nothing.
void turn_blocks(const Eigen::Matrix3d& rotation, double factor,
                 std::span<const Eigen::Matrix3d> in, Eigen::Matrix3d* out);

}  // namespace tremolo
