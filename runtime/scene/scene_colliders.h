// The moving colliders of a scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/result.h"
#include "common/state_stream.h"
#include "runtime/contact/contact_law.h"
#include "runtime/contact_body.h"
#include "runtime/math/motion.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// The shape, read from its file if it has one. Errors: kSystem where the file is missing, naming
// the command that makes it; those of load_collider.
Result<Collider> load_scene_collider(const SceneCollider& collider);
// The shape of a body, read in the same way; nullopt if it has none.
Result<std::optional<Collider>> load_body_shape(const SceneBody& body);

class SceneColliders {
 public:
  // Places them for the first step. Errors, with the collider's name in front: those of
  // load_scene_collider; kContent for a motion that jumps and does not say how.
  static Result<SceneColliders> create(const Scene& scene);

  // Adds one at its pose; its motion begins at t = 0. Errors as for create().
  Status add(const SceneCollider& wanted);

  // Places them for the k-th step, counted from 0. True if one of them has jumped since the end of
  // the step before, which was the last call's. Allocates nothing.
  bool move(std::int64_t k, double step);
  // The collider goes from where it is to that pose in the next step, and rests there until the
  // next call; its motion has ended.
  void move_to(std::size_t i, const Pose& next) { given_[i] = next; }
  // It is at the pose at once, as move_to().
  void put(std::size_t i, const Pose& pose) {
    placed_[i].start = placed_[i].end = pose;
    given_[i] = pose;
  }
  bool is_given(std::size_t i) const { return given_[i].has_value(); }

  // Saves or restores the poses of move_to() and put().
  void carry(StateStream& stream);
  // In the scene's order.
  std::span<const PlacedCollider> placed() const { return placed_; }

 private:
  std::vector<MotionPath> paths_;
  std::vector<std::optional<Pose>> given_;  // by move_to(); empty: the path moves it
  std::vector<PlacedCollider> placed_;
  std::int64_t last_ = -1;  // the step of the last move()
};

// The largest depth of a vertex of the body's boundary in a collider at the start of the step, m,
// and that collider; 0 if no vertex is in one.
struct DeepestPoint {
  double depth = 0.0;
  std::size_t collider = 0;
};
DeepestPoint deepest_point(const ContactBody& body, std::span<const PlacedCollider> colliders);

// The largest depth of a vertex of the body's boundary in the shape of another one, which has
// contact and is at `place`, m; 0 if none is inside or there is no shape.
double depth_in_body(const ContactBody& body, const ContactBody& other, const PresentPlace& place);

// The largest distance of a contact point of the body within the margin of a collider at the start
// of the step, m; 0: none is.
double begins_within_margin(const ContactBody& body, std::span<const PlacedCollider> colliders);

}  // namespace tremolo
