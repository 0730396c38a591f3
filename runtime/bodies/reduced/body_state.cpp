// Body: saves and restores its state between steps; sets other damping, another method.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "common/hash.h"
#include "runtime/bodies/reduced/saved_body.h"
#include "runtime/body.h"

namespace tremolo {
namespace {

// True if all values of an object, which consists of doubles alone, are finite.
template <class Doubles>
bool all_finite(const Doubles& thing) {
  const std::string bytes = state_bytes(thing);
  for (std::size_t at = 0; at < bytes.size(); at += sizeof(double)) {
    double value = 0.0;
    std::memcpy(&value, bytes.data() + at, sizeof(value));
    if (!std::isfinite(value)) return false;
  }
  return true;
}

}  // namespace

std::uint64_t Body::content_hash() const {
  std::string bytes;
  StateStream stream = StateStream::writing(bytes);
  std::string name(integrator_->name());
  IntegratorOptions options = options_;
  FrameKind frame = frame_;
  stream.sized(name);
  stream(frame, options.step, options.newmark_beta, options.newmark_gamma);
  stream(options.split.rule, options.split.count, options.split.safety, options.tolerance);
  stream(options.max_iterations, options.halvings);
  if (skin_) {
    std::size_t count = bones();
    std::vector<double> weights(skin_->drawn.data(), skin_->drawn.data() + skin_->drawn.size());
    stream(count);
    stream.sized(weights);
  }
  return hash_bytes(std::as_bytes(std::span(bytes)));
}

std::vector<std::byte> Body::save() const {
  return save_body(*this);
}

Status Body::restore(std::span<const std::byte> bytes) {
  return restore_body(*this, bytes);
}

void Body::carry(StateStream& stream) {
  DampingRatios damping = damping_of(options_);
  stream(damping);
  if (stream.reads() && stream.good()) stream.require(bool(set_damping(damping)));
  stream(state_, counts_, sums_, bound_, steps_since_look_, moved_);
  stream(sound_, sound_rigid_, sound_sums_);
  stream.require(counts_.steps >= 0 && state_.q.allFinite() && state_.p.allFinite());
  stream.require(sound_.q.allFinite() && sound_.p.allFinite());
  if (stream.reads()) stream.require(all_finite(sums_) && all_finite(sound_sums_));
  carry_frame(stream);
  carry_forces(stream);
  place_forces_.carry(stream);
  if (stream.good()) integrator_->carry(stream);
}

void Body::carry_frame(StateStream& stream) {
  stream(gravity_);
  // A fixed body has a frame since gravity first acted on it.
  bool driven = driven_ != nullptr;
  stream(driven);
  if (!stream.good()) return;
  if (driven && !driven_) {
    stream.require(!free_ && model_->inertia() != nullptr);
    if (!stream.good()) return;
    begin_driven();
  }
  if (!driven) driven_.reset();
  if (driven_) driven_->carry(stream);
  if (!free_) return;
  RigidState rigid = free_->rigid();
  stream(rigid);
  if (stream.reads() && stream.good()) free_->restore(rigid);
}

// Loads in time stay at their indices; those of apply_force() are inserted between them in their
// order.
void Body::carry_forces(StateStream& stream) {
  std::size_t loads = loads_.size();
  stream(loads);
  stream.require(loads == loads_.size());
  stream.sized(applied_);
  for (const AppliedForce& applied : applied_)
    stream.require(applied.force.size() == model_->modes() && applied.steps > 0);
  std::vector<PointForce> lasting;
  std::vector<int> steps;
  for (PointForce& point : points_) steps.push_back(point.steps);
  stream.sized(steps);
  if (!stream.good()) return;
  const auto lasts = [](const auto& some) { return some.steps == 0; };
  if (stream.reads()) {
    for (PointForce& point : points_)
      if (lasts(point)) lasting.push_back(std::move(point));
    stream.require(std::count(steps.begin(), steps.end(), 0) ==
                   static_cast<std::ptrdiff_t>(lasting.size()));
    if (!stream.good()) steps.assign(lasting.size(), 0);
    points_.clear();
    std::size_t next = 0;
    for (const int left : steps) {
      if (left == 0) {
        points_.push_back(std::move(lasting[next++]));
        continue;
      }
      points_.push_back({});
      points_.back().steps = left;
    }
    step_forces_.resize(points_.size());
  }
  for (PointForce& point : points_) {
    if (lasts(point)) continue;
    stream(point.force);
    tremolo::carry(stream, point.place, model_->modes());
  }
}

Status Body::set_damping(const DampingRatios& damping) {
  if (damping == damping_of(options_)) return Success{};
  IntegratorOptions options = options_;
  put_damping(damping, options);
  Result<std::unique_ptr<Integrator>> made = make_integrator(integrator_->name(), model_, options);
  if (!made) return made.error();
  (*made)->follow(*integrator_);
  integrator_ = std::move(*made);
  options_ = options;
  return Success{};
}

Status Body::set_method(std::string_view integrator, double step) {
  IntegratorOptions options = options_;
  options.step = step;
  // The caller that makes such a body checks all that may be wrong.
  Result<Body> made = create(model_, integrator, options, frame_);
  if (!made) return made.error();
  // A method with a staggered momentum passes on the momentum at the state's own time.
  integrator_->synchronized_momentum(state_, momentum_);
  state_.p = momentum_;
  counts_.steps = std::llround(time() / step);
  integrator_ = std::move(made->integrator_);
  options_ = made->options_;
  low_ = made->low_;
  energy_method_ = made->energy_method_;
  if (driven_) driven_->set_step(step);
  keep_sound_state();
  return Success{};
}

}  // namespace tremolo
