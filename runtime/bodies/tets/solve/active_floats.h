// Conjugate gradients over active control points in single precision (active_solve.h), for
// corrections with two or three digits. Most of the time is spent reading the matrix from memory in
// every iteration. Therefore it is in floats, and only the blocks below the diagonal are stored,
// each multiplied with its transpose while it is loaded. Sums of products are in doubles.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "runtime/bodies/tets/elements/float_blocks.h"
#include "runtime/bodies/tets/elements/smooth_modes.h"
#include "runtime/math/kernels/lanes.h"
#include "runtime/math/sparse/block_matrix.h"

namespace tremolo {

class ActiveFloats {
 public:
  // All memory is allocated here, for all nodes active. smooth: of its nodes.
  ActiveFloats(const BlockPattern& pattern, std::shared_ptr<const SmoothSpace> smooth);

  // nodes: the active ones, ascending; rank: index of each node among them, or kNoRank.
  static constexpr std::uint32_t kNoRank = ~std::uint32_t{0};
  void choose(const BlockPattern& pattern, std::span<const std::uint32_t> nodes,
              std::span<const std::uint32_t> rank);

  // Sets the matrix to zero; returns the target to which elements are added (float_blocks.h).
  FloatTarget begin();
  void take(const BlockMatrix& a);
  Eigen::Matrix3d diagonal(std::uint32_t node) const;  // by rank

  // Sets the inverses of the diagonal's blocks and of A_c, and r, and initializes x = 0, p = z = P
  // r. Returns r.z.
  double start(const std::vector<Eigen::Matrix3d>& inverse, const SmoothMatrix& smooth_inverse,
               const std::vector<Eigen::Vector3d>& r);
  double multiply();  // q = A p; returns p.q
  // x += length p, r -= length q, z = P r. Returns r.r and r.z.
  std::pair<double, double> advance(double length);
  void turn(double share);  // p = z + share p

  Eigen::Vector3d direction(std::uint32_t node) const { return three(p_, node); }
  void add_image(std::uint32_t node, const Eigen::Vector3d& value);
  Eigen::Vector3d solution(std::uint32_t node) const { return three(x_, node); }
  std::size_t bytes() const;

 private:
  static Eigen::Vector3d three(const AlignedFloats& list, std::uint32_t node) {
    return Eigen::Map<const Eigen::Vector3f>(list.data() + std::size_t{4} * node).cast<double>();
  }

  std::size_t n_ = 0;
  // Rows of the blocks below the diagonal, each padded with zeros to whole groups: index of each
  // row's first block, and column of each block.
  std::vector<std::uint32_t> first_, column_;
  std::vector<std::uint32_t> at_;    // of the pattern's blocks: see FloatTarget
  AlignedFloats blocks_;             // the diagonal's, and then the rows', in groups
  AlignedFloats inverse_;            // three columns of four floats each
  AlignedFloats x_, r_, z_, p_, q_;  // four floats per node; z_ without its smooth part
  std::shared_ptr<const SmoothSpace> smooth_;
  std::vector<SmoothFields> fields_;  // of the active nodes
  Eigen::Matrix<float, kSmoothModes, kSmoothModes> smooth_inverse_;
  AlignedFloats smooth_part_;  // of z: four floats per field
};

}  // namespace tremolo
