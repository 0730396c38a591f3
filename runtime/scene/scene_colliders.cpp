#include "runtime/scene/scene_colliders.h"

#include <filesystem>
#include <string>
#include <utility>

#include "common/number_text.h"
#include "runtime/contact/solve/contact_step.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

double distance_to(const PlacedCollider& collider, const Vector3d& x) {
  const Pose& pose = collider.start;
  return signed_distance(collider.shape, pose.rotation.conjugate() * (x - pose.position)).distance;
}

Result<PlacedCollider> placed_collider(const SceneCollider& wanted, const MotionPath& path) {
  if (const double jump = path.refused_jump(); jump < kForEver)
    return content_error("its pose jumps at t = " + number_text(jump) +
                         " s: say jumps = \"smooth\" to spread it over smooth-time, or "
                         "\"teleport\" to put it elsewhere at once");
  PlacedCollider placed;
  placed.friction = wanted.friction;
  placed.restitution = wanted.restitution;
  if (Status s = take(placed.shape, load_scene_collider(wanted)); !s) return s.error();
  return placed;
}

}  // namespace

Result<Collider> load_scene_collider(const SceneCollider& collider) {
  if (collider.file.empty()) return collider.shape;
  std::error_code ignored;
  if (!std::filesystem::exists(collider.file, ignored))
    return system_error(collider.file + ": there is no such collider file; make it with `" +
                        (collider.made_by.empty()
                             ? "tremolo-precompute collider SURFACE -o " + collider.file
                             : collider.made_by) +
                        "`");
  return load_collider(collider.file);
}

Result<SceneColliders> SceneColliders::create(const Scene& scene) {
  SceneColliders colliders;
  for (const SceneCollider& wanted : scene.colliders) {
    const Pose base{wanted.pose.position, wanted.pose.rotation.normalized()};
    Result<MotionPath> path = MotionPath::create(wanted.motion, base);
    if (!path) return path.error();
    Result<PlacedCollider> placed = placed_collider(wanted, *path);
    if (!placed)
      return Error{placed.error().kind,
                   "collider '" + wanted.name + "': " + placed.error().message};
    colliders.paths_.push_back(std::move(*path));
    colliders.placed_.push_back(std::move(*placed));
  }
  colliders.move(0, scene.step);
  return colliders;
}

void SceneColliders::move(std::int64_t k, double step) {
  const double t = static_cast<double>(k) * step;
  for (std::size_t i = 0; i < paths_.size(); ++i) {
    const MotionPath& path = paths_[i];
    const std::size_t piece = path.piece(t + 0.5 * step);
    placed_[i].start = path.pose_in(piece, t);
    placed_[i].end = path.pose_in(piece, static_cast<double>(k + 1) * step);
  }
}

DeepestPoint deepest_point(const Body& body, std::span<const PlacedCollider> colliders) {
  std::vector<double> places(3 * body.model().surface().rest.size());
  (void)body.boundary_positions(places);  // the buffer fits
  DeepestPoint deepest;
  for (std::size_t c = 0; c < colliders.size(); ++c)
    for (std::size_t i = 0; i + 2 < places.size(); i += 3) {
      const double depth = -distance_to(colliders[c], Vector3d(places.data() + i));
      if (depth > deepest.depth) deepest = {depth, c};
    }
  return deepest;
}

double contact_energy_at_start(const Body& body, std::span<const PlacedCollider> colliders) {
  const ContactStep* contact = body.contact();
  if (contact == nullptr) return 0.0;
  const ContactPoints& points = contact->points();
  const Pose pose = body.pose();
  double energy = 0.0;
  for (const PlacedCollider& collider : colliders)
    for (std::size_t i = 0; i < points.size(); ++i)
      energy +=
          contact->law().energy(distance_to(collider, pose * points.place(i, body.state().q)));
  return energy;
}

}  // namespace tremolo
