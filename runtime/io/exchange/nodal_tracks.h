// Bodies that move by their vertices, in a recorded motion: tetrahedra and cloths.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/bodies/cloth/cloth_parts.h"
#include "runtime/bodies/tets/scene/tet_scene.h"
#include "runtime/io/exchange/animation.h"
#include "runtime/math/pose.h"

namespace tremolo {

// The pose for which the sum of |place - pose rest|^2 is least. At least one vertex, as many of
// both.
Pose nearest_pose(const std::vector<Eigen::Vector3d>& rest,
                  const std::vector<Eigen::Vector3d>& places);

AnimatedShape tets_shape(const TetsKind& kind);
// The cloth as it is cut, flat, which its vertices are displaced from. Errors: those of
// make_cloth_parts().
Result<AnimatedShape> cloth_shape(const SceneCloth& cloth);

// Append the displacements of a frame, 3 for each vertex of that shape, and return the pose. As
// below.
Pose tets_frame(const TetsKind& kind, const Eigen::VectorXd& positions, const AnimatedShape& shape,
                std::vector<double>& displacements);
void cloth_frame(const ClothParts& parts, const Eigen::VectorXd& x, const AnimatedShape& shape,
                 std::vector<double>& displacements);
// Add a frame to a body of that shape: the pose nearest to all vertices and the displacements from
// it; of a cloth, displacements alone. positions: of the control points, m; x: of the particles, m.
void record_tets(const TetsKind& kind, const Eigen::VectorXd& positions, const AnimatedShape& shape,
                 AnimatedBody& body);
void record_cloth(const ClothParts& parts, const Eigen::VectorXd& x, const AnimatedShape& shape,
                  AnimatedBody& body);

}  // namespace tremolo
