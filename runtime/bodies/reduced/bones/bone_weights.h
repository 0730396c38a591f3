// Weights of bones at points: given, or by the distance to bones that are segments.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/energy.h"
#include "common/result.h"
#include "formats/basis/basis_data.h"

namespace tremolo {

// One row per point, one column per bone, dimensionless; no weight is negative and each row sums to
// one.
using BoneWeights = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Largest difference of a given row's sum from 1; the row is normalized.
inline constexpr double kWeightSlack = 1e-3;

// The problem of invalid weights, with the row (from 1); empty for valid ones.
std::string weights_problem(const BoneWeights& weights);

// A bone at rest, in the mesh's coordinates, m. Both ends may be one point.
struct BoneSegment {
  Eigen::Vector3d head = Eigen::Vector3d::Zero();
  Eigen::Vector3d tail = Eigen::Vector3d::Zero();

  double distance(const Eigen::Vector3d& x) const;  // m
};

// The nearest bone moves a point. A bone that is farther by less than `blend` (m, above 0) has a
// weight too: with d the distance, w_b ~ S(1 - (d_b - d_nearest)/blend), S(x) = x^2 (3 - 2x),
// normalized to sum to one. Continuous in X; where the next bone is farther than that, weights are
// 0 and 1.
BoneWeights weights_near(std::span<const Eigen::Vector3d> points,
                         std::span<const BoneSegment> bones, double blend);

// For each point the weights of the nearest one of the known points; the first of several. known:
// one point for each row of `weights`, at least one.
BoneWeights weights_of_nearest(std::span<const Eigen::Vector3d> points,
                               std::span<const Eigen::Vector3d> known, const BoneWeights& weights);

// The inertia integrals of each bone's weighted part of a body (docs/theory.md, "A body on bones"):
// those of common/energy.h with rho w_b instead of rho.

// A solid with its vertices in two blocks, which together contain each vertex of the mesh once.
struct WeighedSolid {
  const VertexBlock& surface;
  const VertexBlock& interior;
  const MassElements& elements;
  // Of quadratic elements, ascending by point; none of linear ones.
  const std::vector<MeshEdge>& edges;
  const InertiaIntegrals& whole;  // the integrals of the whole solid
};

// One per bone, from the consistent mass matrix of each tetrahedron times the mean of its corners'
// weights. The rounding error of their sum (above all of a compact file) is distributed by mass, so
// that they sum to `whole`. surface, interior: the weights of the blocks' vertices. Errors:
// kContent if the elements name a vertex or an edge that does not exist, or their sum differs from
// `whole` by more than one in a thousand: the body has point masses, or its mass matrix is lumped.
Result<std::vector<InertiaIntegrals>> share_inertia(const WeighedSolid& solid,
                                                    const BoneWeights& surface,
                                                    const BoneWeights& interior);

}  // namespace tremolo
