// The colliders of a scene, which move as their motions say.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/result.h"
#include "runtime/contact/contact_law.h"
#include "runtime/contact_body.h"
#include "runtime/scene/motion.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// The shape, read from its file if it has one. Errors: kSystem where the file is missing, naming
// the command that makes it; those of load_collider.
Result<Collider> load_scene_collider(const SceneCollider& collider);
// Likewise the shape of a body; nullopt if it has none.
Result<std::optional<Collider>> load_body_shape(const SceneBody& body);

class SceneColliders {
 public:
  // They are where the first step finds them. Errors, with the collider's name in front: those of
  // load_scene_collider; kContent for a motion that jumps and does not say how.
  static Result<SceneColliders> create(const Scene& scene);

  // Puts them where they are in the k-th step, counted from 0. Nothing is allocated.
  void move(std::int64_t k, double step);
  // In the scene's order.
  std::span<const PlacedCollider> placed() const { return placed_; }

 private:
  std::vector<MotionPath> paths_;
  std::vector<PlacedCollider> placed_;
};

// How deep a vertex of the body's boundary is in a collider at the start of the step, and in which;
// 0 if none is. depth: m.
struct DeepestPoint {
  double depth = 0.0;
  std::size_t collider = 0;
};
DeepestPoint deepest_point(const ContactBody& body, std::span<const PlacedCollider> colliders);

// How far a contact point of the body is within the margin of a collider at the start of the step,
// m; 0: none is.
double begins_within_margin(const ContactBody& body, std::span<const PlacedCollider> colliders);

}  // namespace tremolo
