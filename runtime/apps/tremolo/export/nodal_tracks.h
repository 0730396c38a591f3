// Bodies that move by their vertices, in a recorded motion: tetrahedra and cloths, of scenes of
// their own and as guests of a world.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/bodies/cloth/cloth_parts.h"
#include "runtime/bodies/tets/scene/tet_scene.h"
#include "runtime/io/exchange/animation.h"
#include "runtime/math/pose.h"
#include "runtime/world/world_guests.h"

namespace tremolo {

// The pose for which the sum of |place - pose rest|^2 is least. At least one vertex, as many of
// both.
Pose nearest_pose(const std::vector<Eigen::Vector3d>& rest,
                  const std::vector<Eigen::Vector3d>& places);

AnimatedShape tets_shape(const TetsKind& kind);
// The cloth as it is cut, flat, which its vertices are displaced from. Errors: those of
// make_cloth_parts().
Result<AnimatedShape> cloth_shape(const SceneCloth& cloth);

// Add a frame to a body of that shape: the pose nearest to all vertices and the displacements from
// it; of a cloth, displacements alone. positions: of the control points, m; x: of the particles, m.
void record_tets(const TetsKind& kind, const Eigen::VectorXd& positions, const AnimatedShape& shape,
                 AnimatedBody& body);
void record_cloth(const ClothParts& parts, const Eigen::VectorXd& x, const AnimatedShape& shape,
                  AnimatedBody& body);

// The guests of a world during its recording.
class GuestTracks {
 public:
  // guests: must outlive this object. Errors: those of cloth_shape().
  static Result<GuestTracks> create(const WorldGuests& guests);

  void record();  // adds a frame
  // Moves all tracks behind the animation's own.
  void add_to(Animation& animation);

 private:
  const WorldGuests* guests_ = nullptr;
  std::vector<AnimatedShape> shapes_;  // of kinds of tetrahedra, then of cloths
  std::vector<AnimatedBody> bodies_;
};

}  // namespace tremolo
