#include "runtime/viewer/live/hand_record.h"

#include <utility>

#include "runtime/viewer/live/recorded_text.h"

namespace tremolo {

void HandRecord::before_step(const LiveWorld& live) {
  const LiveHand& hand = live.hand();
  const SceneWorld& world = live.world();
  if (!hand.holds()) return end(world.time());
  const double h = world.step_size();
  if (!holds_) {
    SceneHand taken;
    taken.body = world.name(hand.body());
    taken.at = std::to_string(hand.vertex());
    taken.stiffness = hand.springs().stiffness;
    taken.damping = hand.springs().damping;
    taken.from = world.time();
    taken.motion = hand_motion();
    hands_.push_back(std::move(taken));
    add_hand_key(hands_.back().motion, world.time(), Eigen::Vector3d::Zero());
    holds_ = true;
  }
  add_hand_key(hands_.back().motion, static_cast<double>(world.steps() + 1) * h, hand.way());
}

void HandRecord::end(double time) {
  if (!std::exchange(holds_, false)) return;
  hands_.back().until = time;
}

void HandRecord::clear() {
  hands_.clear();
  holds_ = false;
}

}  // namespace tremolo
