#include "runtime/viewer/live/hand_record.h"

#include <utility>
#include <variant>

namespace tremolo {
namespace {

std::vector<Keyframe>& keys_of(SceneHand& hand) {
  return std::get<KeyframeMotion>(hand.motion.parts.front()).keys;
}

// A key that lies between two at the same place says nothing.
void add_key(std::vector<Keyframe>& keys, double time, const Eigen::Vector3d& way) {
  const std::size_t count = keys.size();
  if (count > 1 && keys[count - 1].pose.position == way && keys[count - 2].pose.position == way)
    keys.pop_back();
  keys.push_back({time, {way, Eigen::Quaterniond::Identity()}});
}

}  // namespace

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
    taken.motion.parts = {KeyframeMotion{.keys = {}, .interpolation = Interpolation::kLinear}};
    hands_.push_back(std::move(taken));
    add_key(keys_of(hands_.back()), world.time(), Eigen::Vector3d::Zero());
    holds_ = true;
  }
  add_key(keys_of(hands_.back()), static_cast<double>(world.steps() + 1) * h, hand.way());
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
