// Body: saves and restores its state between steps; sets other damping, another method.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "common/hash.h"
#include "common/restore_state.h"
#include "formats/saved/saved_file.h"
#include "runtime/body.h"
#include "runtime/contact/solve/contact_step.h"

namespace tremolo {
namespace {

SavedState state_of(const Body& body) {
  return {"a body",
          TREMOLO_VERSION,
          {{"model", body.model().content_hash()}, {"method or frame", body.content_hash()}},
          {}};
}

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

bool is_finite_account(const ContactAccount& account) {
  for (const double value : {account.energy, account.work, account.lost, account.rubbed,
                             account.given, account.surplus, account.hand_work, account.hand_damped,
                             account.penetration, account.joint_work, account.way, account.impulse})
    if (!std::isfinite(value)) return false;
  return account.impulse_vector.allFinite();
}

bool is_finite_grip(const Grip& grip) {
  return std::isfinite(grip.work) && std::isfinite(grip.damped) && grip.start.allFinite() &&
         grip.end.allFinite() && grip.force.allFinite();
}

}  // namespace

std::uint64_t Body::content_hash() const {
  std::string bytes;
  StateStream stream = StateStream::writing(bytes);
  std::string name(integrator_->name());
  IntegratorOptions options = options_;
  FrameKind frame = frame_;
  bool touches = contact_ != nullptr;
  stream.sized(name);
  stream(frame, touches, options.step, options.newmark_beta, options.newmark_gamma);
  stream(options.split.rule, options.split.count, options.split.safety, options.tolerance);
  stream(options.max_iterations, options.halvings);
  if (skin_) {
    std::size_t count = bones();
    std::vector<double> weights(skin_->drawn.data(), skin_->drawn.data() + skin_->drawn.size());
    stream(count);
    stream.sized(weights);
  }
  if (touches) {
    ContactLaw law = contact_->law();
    std::vector<VertexId> ids = contact_->points().ids;
    bool feels = contact_->feels(), shape = contact_->shape() != nullptr;
    stream(law.margin, law.stiffness, law.friction, law.restitution, feels, shape);
    stream.sized(ids);
  }
  return hash_bytes(std::as_bytes(std::span(bytes)));
}

std::vector<std::byte> Body::save() const {
  SavedState saved = state_of(*this);
  saved.state = state_bytes(*this);
  return encode_saved(saved);
}

Status Body::restore(std::span<const std::byte> bytes) {
  const std::string name = "the saved body";
  const Result<SavedState> saved = read_saved(bytes, name);
  if (!saved) return saved.error();
  if (Status s = check_belongs(*saved, state_of(*this)); !s) return error_of_file(name, s.error());
  if (!restore_state(*this, saved->state))
    return content_error(name + ": it does not fit this body: other loads, or made by hand");
  return Success{};
}

void Body::carry(StateStream& stream) {
  double alpha = options_.alpha, beta = options_.beta;
  stream(alpha, beta);
  if (stream.reads() && stream.good()) stream.require(bool(set_damping(alpha, beta)));
  stream(state_, steps_, iterations_, halved_steps_, sums_, bound_, steps_since_look_);
  stream(sound_, sound_rigid_, sound_sums_);
  stream.require(steps_ >= 0 && state_.q.allFinite() && state_.p.allFinite());
  stream.require(sound_.q.allFinite() && sound_.p.allFinite());
  if (stream.reads()) stream.require(all_finite(sums_) && all_finite(sound_sums_));
  carry_frame(stream);
  carry_forces(stream);
  carry_hands(stream);
  place_forces_.carry(stream);
  if (contact_) contact_->carry(stream);
  if (contact_ && stream.reads()) stream.require(is_finite_account(contact_->account()));
  if (stream.reads())
    for (const Grip& grip : grips_) stream.require(is_finite_grip(grip));
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

void Body::carry_hands(StateStream& stream) {
  std::size_t count = grips_.size();
  stream(count, next_hand_);
  stream.require(count == 0 || (contact_ != nullptr && count <= stream.left() / 64) ||
                 !stream.reads());
  if (!stream.good()) return;
  if (stream.reads()) {
    grips_.resize(count);
    hands_.resize(count);
  }
  for (std::size_t i = 0; i < count && stream.good(); ++i) {
    tremolo::carry(stream, grips_[i], model_->modes());
    stream(hands_[i]);
    const Result<VertexRows> vertex = model_->vertex(grips_[i].vertex);
    grips_[i].at_vertex = vertex && vertex->rest == grips_[i].place.rest;
    stream.require(hands_[i] < next_hand_);
  }
}

Status Body::set_damping(double alpha, double beta) {
  if (alpha == options_.alpha && beta == options_.beta) return Success{};
  IntegratorOptions options = options_;
  options.alpha = alpha;
  options.beta = beta;
  Result<std::unique_ptr<Integrator>> made = make_integrator(integrator_->name(), model_, options);
  if (!made) return made.error();
  (*made)->follow(*integrator_);
  integrator_ = std::move(*made);
  options_ = options;
  if (contact_) contact_->set_damping(alpha, beta);
  return Success{};
}

Status Body::set_method(std::string_view integrator, double step) {
  IntegratorOptions options = options_;
  options.step = step;
  // The caller that makes such a body checks all that may be wrong.
  Result<Body> made = create(model_, integrator, options, frame_);
  if (!made) return made.error();
  if (contact_ && frame() != FrameKind::kFixed && !made->energy_method_)
    return usage_error("contact goes with avf, ep2 and ep4");
  // A method with a staggered momentum passes on the momentum at the state's own time.
  integrator_->synchronized_momentum(state_, momentum_);
  state_.p = momentum_;
  steps_ = std::llround(time() / step);
  integrator_ = std::move(made->integrator_);
  options_ = made->options_;
  low_ = made->low_;
  energy_method_ = made->energy_method_;
  if (driven_) driven_->set_step(step);
  if (contact_) contact_->set_step(step);
  for (Grip& grip : grips_) limit_hand(grip);
  keep_sound_state();
  return Success{};
}

}  // namespace tremolo
