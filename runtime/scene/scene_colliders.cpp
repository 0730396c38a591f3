#include "runtime/scene/scene_colliders.h"

#include <cmath>
#include <filesystem>
#include <string>
#include <utility>

#include "common/text.h"
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

Result<Collider> load_made_collider(const std::string& file, const std::string& made_by) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored))
    return system_error(
        file + ": there is no such collider file; make it with `" +
        (made_by.empty() ? "tremolo-precompute collider SURFACE -o " + file : made_by) + "`");
  return load_collider(file);
}

}  // namespace

Result<Collider> load_scene_collider(const SceneCollider& collider) {
  if (collider.file.empty()) return collider.shape;
  return load_made_collider(collider.file, collider.made_by);
}

Result<std::optional<Collider>> load_body_shape(const SceneBody& body) {
  if (body.shape_file.empty()) return body.contact.shape;
  Result<Collider> shape = load_made_collider(body.shape_file, body.shape_made_by);
  if (!shape) return shape.error();
  return std::optional<Collider>(std::move(*shape));
}

Result<SceneColliders> SceneColliders::create(const Scene& scene) {
  SceneColliders colliders;
  for (const SceneCollider& wanted : scene.colliders)
    if (Status s = colliders.add(wanted); !s) return s.error();
  (void)colliders.move(0, scene.step);
  return colliders;
}

Status SceneColliders::add(const SceneCollider& wanted) {
  const Pose base{wanted.pose.position, wanted.pose.rotation.normalized()};
  Result<MotionPath> path = MotionPath::create(wanted.motion, base);
  if (!path) return path.error();
  Result<PlacedCollider> placed = placed_collider(wanted, *path);
  if (!placed)
    return Error{placed.error().kind, "collider '" + wanted.name + "': " + placed.error().message};
  placed->start = placed->end = path->pose_in(path->piece(0.0), 0.0);
  paths_.push_back(std::move(*path));
  placed_.push_back(std::move(*placed));
  given_.emplace_back();
  return Success{};
}

bool SceneColliders::move(std::int64_t k, double step) {
  constexpr double kSame = 1e-9;  // of poses, m or 1
  const bool follows = k == last_ + 1 && k > 0;
  last_ = k;
  bool jumped = false;
  const double t = static_cast<double>(k) * step;
  for (std::size_t i = 0; i < paths_.size(); ++i) {
    const Pose before = placed_[i].end;
    if (given_[i]) {
      placed_[i].start = before;
      placed_[i].end = *given_[i];
      continue;
    }
    const MotionPath& path = paths_[i];
    const std::size_t piece = path.piece(t + 0.5 * step);
    placed_[i].start = path.pose_in(piece, t);
    placed_[i].end = path.pose_in(piece, static_cast<double>(k + 1) * step);
    const Pose& start = placed_[i].start;
    const double turn = std::abs(start.rotation.dot(before.rotation));
    jumped = jumped || (start.position - before.position).norm() > kSame || turn < 1.0 - kSame;
  }
  return follows && jumped;
}

void SceneColliders::carry(StateStream& stream) {
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    if (!given_[i]) continue;
    for (Pose* pose : {&*given_[i], &placed_[i].start, &placed_[i].end}) {
      stream(*pose);
      stream.require(pose->position.allFinite() && std::abs(pose->rotation.norm() - 1.0) <= 1e-6);
    }
  }
}

DeepestPoint deepest_point(const ContactBody& body, std::span<const PlacedCollider> colliders) {
  std::vector<double> places(3 * body.model().surface().rest.size());
  (void)body.surface_positions(places, SurfaceKind::kBoundary);  // the buffer fits
  DeepestPoint deepest;
  for (std::size_t c = 0; c < colliders.size(); ++c)
    for (std::size_t i = 0; i + 2 < places.size(); i += 3) {
      const double depth = -distance_to(colliders[c], Vector3d(places.data() + i));
      if (depth > deepest.depth) deepest = {depth, c};
    }
  if (body.contact() == nullptr) return deepest;
  const ContactPoints& points = *body.contact()->surface().points;
  for (std::size_t c = 0; c < colliders.size(); ++c)
    for (std::size_t i = 0; i < points.round; ++i) {
      const double depth =
          points.round_radius - distance_to(colliders[c], body.pose() * points.rest[i]);
      if (depth > deepest.depth) deepest = {depth, c};
    }
  return deepest;
}

double depth_in_body(const ContactBody& body, const ContactBody& other, const PresentPlace& place) {
  const Collider* shape = other.contact()->surface().shape_or_null();
  if (shape == nullptr) return 0.0;
  std::vector<double> places(3 * body.model().surface().rest.size());
  (void)body.surface_positions(places, SurfaceKind::kBoundary);  // the buffer fits
  double depth = 0.0;
  for (std::size_t i = 0; i + 2 < places.size(); i += 3)
    depth = std::max(depth, place.depth_in(*shape, Vector3d(places.data() + i)));
  if (body.contact() == nullptr) return depth;
  const ContactPoints& points = *body.contact()->surface().points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double round = points.radius_of(i);
    depth = std::max(depth, round + place.depth_in(*shape, body.contact_point(i), round));
  }
  return depth;
}

double begins_within_margin(const ContactBody& body, std::span<const PlacedCollider> colliders) {
  const ContactStep* contact = body.contact();
  if (contact == nullptr) return 0.0;
  const ContactPoints& points = *contact->surface().points;
  double deepest = 0.0;
  for (const PlacedCollider& collider : colliders)
    for (std::size_t i = 0; i < points.size(); ++i)
      if (points.meets(i, true))
        deepest = std::max(deepest, contact->surface().law.margin + points.radius_of(i) -
                                        distance_to(collider, body.contact_point(i)));
  return deepest;
}

}  // namespace tremolo
