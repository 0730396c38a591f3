// Springs and dampers of one kind between particles.
//
// Spring a-b, rest length L, stiffness k, damping d; r = x_a - x_b, l = |r|, e = r/l, w = v_a -
// v_b:
//
//   V = k/2 (l - L)^2,   force on a: -[k (l - L) + d w.e] e,   on b: its opposite
//
// Over a step from r0 to r1 let m = r0 + r1 and u = m/|m|. The force below conserves V, momentum
// and angular momentum (V1 - V0 = k/2 (l0 + l1 - 2 L)(l1 - l0), and m.(r1 - r0) = l1^2 - l0^2):
//
//   force on a: -k/2 (l0 + l1 - 2 L)/(l0 + l1) m - d u.(r1 - r0)/h u
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "runtime/bodies/cloth/cloth_parts.h"
#include "runtime/math/sparse/block_matrix.h"
#include "runtime/step/nodal_system.h"

namespace tremolo {

// A part of the springs that is computed at a time.
struct SpringChunk {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  // True: both ends of each spring are one particle after those of the spring before it, so that
  // their data is contiguous.
  bool run = false;
};

// Weights of a tangent: a += position (-df/dx) + velocity (-df/dv). With P = I - e e^T,
//   -df_a/dx_a = k [(1 - L/l) P + e e^T] + (d/l) [e (P w)^T + (w.e) P],   -df_a/dv_a = d e e^T
// The part e (P w)^T, which is not symmetric, is left out. Where P's factor is negative, `share` of
// it is kept, 0 to 1.
struct SpringWeights {
  double position, velocity, share;
};

// Chunks from `chunk` on, up to the first that starts at `particle` or after it.
struct SpringPart {
  std::size_t chunk = 0;
  std::uint32_t particle = 0;
};

class SpringSet {
 public:
  SpringSet() = default;
  explicit SpringSet(const ClothSprings& springs);

  std::size_t size() const { return a_.size(); }
  const SpringLaw& law() const { return law_; }

  // Finds the blocks of a pattern that has all pairs.
  void find_places(const BlockPattern& pattern);

  // f += the springs' forces. This and the following functions allocate nothing.
  void add_force(const Eigen::VectorXd& x, const Eigen::VectorXd& v, Eigen::VectorXd& f) const;
  // Adds the tangents of a part to a; returns the next chunk. Springs of several kinds are added
  // part by part, because they share blocks and the matrix does not fit into the second cache.
  std::size_t add_tangent(const SpringPart& part, const Eigen::VectorXd& x,
                          const Eigen::VectorXd& v, const SpringWeights& weights,
                          BlockMatrix& a) const;
  double energy(const Eigen::VectorXd& x) const;                                   // J
  double damping_power(const Eigen::VectorXd& x, const Eigen::VectorXd& v) const;  // W

  // f += the force over a step; returns the energy that the dampers took, J.
  double add_step_force(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double h,
                        Eigen::VectorXd& f) const;
  // a += approximately -df/dx1 of that force: its symmetric part, with `share` of negative terms, 0
  // to 1.
  void add_step_tangent(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double h,
                        double share, BlockMatrix& a) const;

  // y += the product with u of the terms that are missing in the two tangents with share 1:
  // position times (d/l) e (P w)^T of a spring, and those of -df/dx1 of the force over a step.
  // Vectors have three numbers a particle.
  void add_missing_product(const Eigen::VectorXd& x, const Eigen::VectorXd& v, double position,
                           const Eigen::VectorXd& u, Eigen::VectorXd& y) const;
  void add_missing_step_product(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double h,
                                const Eigen::VectorXd& u, Eigen::VectorXd& y) const;

 private:
  Eigen::Vector3d between(const Eigen::VectorXd& x, std::size_t spring) const {
    return x.segment<3>(3 * a_[spring]) - x.segment<3>(3 * b_[spring]);
  }
  void add_block(std::size_t spring, const Eigen::Matrix3d& block, BlockMatrix& a) const;

  SpringLaw law_;
  std::vector<std::uint32_t> a_, b_;
  std::vector<double> rest_;
  std::vector<SpringChunk> chunks_;
  std::vector<std::uint32_t> place_a_, place_b_, place_ab_;
};

}  // namespace tremolo
