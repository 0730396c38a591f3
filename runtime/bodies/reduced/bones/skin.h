// A body's skin on its bones, by linear blending:
//
//     x = sum_b w_b(X) T_b (X + U q),     T_b y = c_b + R_b y
//
// T_b is the pose of bone b relative to its pose at rest, in the mesh's coordinates.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "runtime/bodies/reduced/bones/bone_weights.h"
#include "runtime/bodies/reduced/frames/frame_inertia.h"
#include "runtime/math/pose.h"

namespace tremolo {

// A skin for one model (runtime/bones.h); bodies share it.
struct Skin {
  // Weights of the drawn vertices, of the boundary's and of those inside.
  BoneWeights drawn, surface, interior;
  // Inertia of each bone's weighted part of the body, about the mesh's origin.
  std::vector<std::shared_ptr<const FrameInertia>> shares;
  std::vector<std::string> names = {};  // one a bone, or none

  std::size_t bones() const { return shares.size(); }
};

// The matrix [R c] of a pose.
using BoneMap = Eigen::Matrix<double, 3, 4>;

inline BoneMap bone_map(const Pose& pose) {
  BoneMap map;
  map << pose.rotation.toRotationMatrix(), pose.position;
  return map;
}

// sum_b w_b [R_b c_b]. Weights of zero cost nothing.
template <class Weights>
BoneMap blended(const Weights& weights, std::span<const BoneMap> maps) {
  BoneMap sum = BoneMap::Zero();
  for (std::size_t b = 0; b < maps.size(); ++b)
    if (const double weight = weights[b]; weight != 0.0) sum += weight * maps[b];
  return sum;
}

// Moves positions x y z x y z ..., one per row of the weights, in place. Nothing is allocated.
template <class Number>
void skin_places(const BoneWeights& weights, std::span<const BoneMap> maps,
                 std::span<Number> places) {
  using Vector = Eigen::Matrix<Number, 3, 1>;
  for (std::size_t i = 0; i + 2 < places.size(); i += 3) {
    const Eigen::Matrix<Number, 3, 4> map =
        blended(weights.row(i / 3), maps).template cast<Number>();
    Eigen::Map<Vector> x(places.data() + i);
    x = (map.template leftCols<3>() * x + map.col(3)).eval();
  }
}

// Rotates unit normals in the same order and normalizes them: exact where one bone moves a vertex,
// without the slope of the weights elsewhere. A zero normal stays zero.
template <class Number>
void skin_normals(const BoneWeights& weights, std::span<const BoneMap> maps,
                  std::span<Number> normals) {
  using Vector = Eigen::Matrix<Number, 3, 1>;
  for (std::size_t i = 0; i + 2 < normals.size(); i += 3) {
    const auto row = weights.row(i / 3);
    const Eigen::Matrix<Number, 3, 4> map = blended(row, maps).template cast<Number>();
    Eigen::Map<Vector> x(normals.data() + i);
    x = (map.template leftCols<3>() * x).eval();
    if (const Number length = x.norm(); length > Number(0) && row.maxCoeff() < 1.0) x /= length;
  }
}

}  // namespace tremolo
