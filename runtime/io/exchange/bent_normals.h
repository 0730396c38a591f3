// Normals of strongly bent shapes, as morph targets of normals alone.
//
// The first order in q (runtime/io/exchange/morph_targets.h) shows a normal L(t) instead of the
// bent shape's unit normal e(t). What is missing, r = (e.L) e - L at each vertex, is collected over
// frames; its first singular vectors are the targets, D_j, and their weights in a frame are
// D_j^T r. For a number of targets no other ones leave less of r, summed over vertices and frames.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "runtime/io/exchange/animation.h"
#include "runtime/io/exchange/morph_targets.h"

namespace tremolo {

// weights: of each body of the animation, targets x frames; of bodies of other shapes empty.
struct BentNormals {
  std::size_t targets = 0;
  std::vector<Eigen::MatrixXf> weights;
};

// Appends the targets to the columns of targets.normals, whose base keeps length one. At most
// `count`, fewer where fewer are enough. plain: weights are not brought into [0, 1].
BentNormals add_bent_normals(const Animation& animation, std::size_t shape,
                             const TargetRanges& ranges, bool plain, std::size_t count,
                             MorphTargets& targets);

}  // namespace tremolo
