// Grabs of particles of a world's cloths: those of the scene and the user's.
#include <string>
#include <utility>

#include "runtime/bodies/cloth/cloth_world_inside.h"

namespace tremolo {

using Eigen::Vector3d;

// The motion of a grabbed particle no longer counts, and that of a released one does again. The
// state of methods between steps is discarded only where a particle becomes fixed or free.
void ClothWorld::Inside::hold(WorldCloth& cloth, std::size_t particle, const Vector3d& at) {
  const bool was_free = cloth.model.held()[particle] == 0;
  const double before = was_free ? free_cloth_kinetic(cloth) : 0.0;
  cloth.model.hold(particle, at);
  if (!was_free) return;
  sums.pins += free_cloth_kinetic(cloth) - before;
  cloth.integrator->reset();
}

void ClothWorld::Inside::let_go(WorldCloth& cloth, std::size_t particle) {
  const double before = free_cloth_kinetic(cloth);
  if (cloth.model.let_go(particle)) cloth.integrator->reset();
  sums.pins += free_cloth_kinetic(cloth) - before;
}

// wanted: has passed check_scene(), so that its cloth exists.
Status ClothWorld::Inside::add_hand(const ClothHand& wanted) {
  WorldHand hand;
  hand.particle = wanted.particle;
  hand.from = wanted.from;
  hand.until = wanted.until;
  while (cloths[hand.cloth]->scene.name != wanted.cloth) ++hand.cloth;
  const ClothParts& parts = cloths[hand.cloth]->model.parts();
  const std::size_t particles = parts.vertices();
  if (hand.particle >= particles)
    return content_error("a hand holds particle " + std::to_string(hand.particle) + " of cloth '" +
                         wanted.cloth + "', but there are " + std::to_string(particles));
  hand.particle = parts.particle_of_vertex(hand.particle);
  if (Status s = take(hand.path, MotionPath::create(wanted.motion)); !s) return s;
  cloths[hand.cloth]->model.expect_hold();
  hands.push_back(std::move(hand));
  return Success{};
}

// Before a step: moves each to its position at the end. Grabs whose time is over are released
// first, so that another one may hold the same particle.
void ClothWorld::Inside::move_hands() {
  const double h = scene.options.step, t = static_cast<double>(steps) * h;
  const double now = t + kSameTime * h, end = static_cast<double>(steps + 1) * h;
  for (WorldHand& hand : hands) {
    if (hand.over || now < hand.until) continue;
    hand.over = true;
    if (hand.holds) let_go(*cloths[hand.cloth], hand.particle);
  }
  for (WorldHand& hand : hands) {
    if (hand.over || now < hand.from) continue;
    WorldCloth& cloth = *cloths[hand.cloth];
    const std::size_t piece = hand.path.piece(t + 0.5 * h);
    if (!hand.holds) {
      const Pose begun = hand.path.pose_in(piece, t);
      const auto at = 3 * static_cast<Eigen::Index>(hand.particle);
      const Vector3d place = cloth.state.x.segment<3>(at);
      hand.base = begun.rotation.conjugate() * (place - begun.position);
      hand.holds = true;
    }
    hold(cloth, hand.particle, hand.path.pose_in(piece, end) * hand.base);
  }
}

Status ClothWorld::hold(std::size_t cloth, std::size_t particle, const Vector3d& at) {
  if (cloth >= cloths() || particle >= particles(cloth))
    return usage_error("there is no particle " + std::to_string(particle) + " of cloth " +
                       std::to_string(cloth));
  if (!at.allFinite()) return usage_error("the point that holds is not finite");
  inside_->hold(*inside_->cloths[cloth], particle, at);
  return Success{};
}

Status ClothWorld::let_go(std::size_t cloth, std::size_t particle) {
  if (cloth >= cloths() || particle >= particles(cloth))
    return usage_error("there is no particle " + std::to_string(particle) + " of cloth " +
                       std::to_string(cloth));
  inside_->let_go(*inside_->cloths[cloth], particle);
  return Success{};
}

}  // namespace tremolo
