// The nearest motion, in kinetic energy, that a system's degrees allow:
//   y <- E (E^T M E)^-1 E^T M y,
// with E the map from the free control points to all (tet_system.h). If linear edges follow their
// ends, rest = y - E y_ends remains; the unknown is E d with E^T M E d = E^T M rest.
//
// M has one number per block. All axes of all vectors are solved for at once, in the lanes of one
// register, by conjugate gradients in single precision. The preconditioner is the sums of the rows
// of E^T M E; the condition is at most 21, that of the mass matrix of one quadratic Bernstein
// tetrahedron. The rest is small relative to y, so that an error of 1e-6 of it is negligible. The
// sum of M y, which a free body must conserve, is corrected to rounding.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "runtime/bodies/tets/elements/tet_system.h"
#include "runtime/math/kernels/lanes.h"

namespace tremolo {

class MassProjection {
 public:
  static constexpr std::size_t kMostVectors = 4;
  static constexpr std::size_t kMassLanes = 16;  // three of each vector, and four zeros

  // All memory is allocated here.
  explicit MassProjection(const TetModel& model);

  // vectors: at most kMostVectors, 3 nodes() long; fixed control points do not move. keep_sums: the
  // sums of M y are conserved. Returns the number of iterations. Allocates nothing.
  int project(const TetSystem& system, std::span<Eigen::VectorXd* const> vectors, bool keep_sums);
  std::size_t bytes() const;

 private:
  void take_rests(const TetSystem& system, std::span<Eigen::VectorXd* const> vectors);
  void choose(const TetSystem& system);
  int search(const TetSystem& system);

  std::vector<float> masses_;          // of the pattern's blocks
  std::vector<std::uint32_t> linear_;  // edges
  AlignedFloats inverse_;              // one over the row sums; zero where no node is free
  AlignedFloats x_, r_, p_, q_;        // kMassLanes per node
  std::array<double, kMassLanes> scale_{};
  Eigen::VectorXd rest_, weight_;  // weight_: M 1
};

}  // namespace tremolo
