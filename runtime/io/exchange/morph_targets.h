// A shape and its modes as glTF's morph targets: a base and deltas, in float.
//
//     x = B + sum_i w_i D_i
//
// Bounded: B = X + sum_i low_i U_i, D_i = (high_i - low_i) U_i, w_i = (q_i - low_i)/(high_i -
// low_i) in [0, 1], low and high over all frames of all bodies of the shape: the same positions as
//
// Plain:   B = X, D_i = U_i, w_i = q_i.
//
// Normals are those of the rest shape, N/|N|, with the first order of N in q. They are right where
// the shape is at rest and err by the second order elsewhere.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "runtime/io/exchange/animation.h"

namespace tremolo {

// Unit normals of the shape with its vertices at `places`, m, s vectors. Triangles are weighted by
// area, and smooth groups share a normal; zero if there is none.
std::vector<Eigen::Vector3d> smooth_normals(const AnimatedShape& shape,
                                            const std::vector<Eigen::Vector3d>& places);

// The map from a coordinate to a weight: w = (q - low)/width.
struct TargetRange {
  Eigen::Index coordinate = 0;
  double low = 0.0;
  double width = 1.0;
};

// The coordinates of a shape as targets.
struct TargetRanges {
  Eigen::VectorXd low;  // r, the coordinates of the base
  // Coordinates that change; in the plain form, those that are not always zero.
  std::vector<TargetRange> targets;
};

TargetRanges target_ranges(const Animation& animation, std::size_t shape, bool plain);

// Column 0 is the base, column i + 1 the delta of target i; 3s rows.
struct MorphTargets {
  Eigen::MatrixXf positions;
  Eigen::MatrixXf normals;  // those of the base have unit length; no columns unless requested
};

MorphTargets morph_targets(const AnimatedShape& shape, const TargetRanges& ranges, bool normals);

// The weights of a frame, as many as targets.
std::vector<float> target_weights(const Eigen::VectorXd& q, const TargetRanges& ranges);

// The error of floats and of the first order, over evenly spaced frames, at most 64. position: the
// largest distance from X + U q, over the shape's size. normal_mean, normal_max: degrees between
// the normals and those of the bent shape, each vertex with the same weight; zero without normals.
// further: weights of each body, columns x frames, of the columns of the normals behind those of
// the ranges (runtime/io/exchange/bent_normals.h); none: there are no such columns.
struct MorphError {
  double position = 0.0;     // the largest distance from X + U q, relative to the shape's size
  double normal_mean = 0.0;  // degrees to the normals of the deformed shape, over all vertices
  double normal_max = 0.0;   // degrees; both are zero without normals
};

MorphError morph_error(const Animation& animation, std::size_t shape, const TargetRanges& ranges,
                       const MorphTargets& targets, std::span<const Eigen::MatrixXf> further = {});

}  // namespace tremolo
