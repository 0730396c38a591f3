// ContactBody: saves and restores its state between steps; sets other damping, another method.
#include <cmath>
#include <string>

#include "common/hash.h"
#include "runtime/bodies/reduced/saved_body.h"
#include "runtime/contact/solve/contact_step.h"
#include "runtime/contact_body.h"

namespace tremolo {
namespace {

bool is_finite_account(const ContactAccount& account) {
  for (const double value : {account.energy, account.work, account.lost, account.friction_loss,
                             account.given, account.surplus, account.hand_work, account.hand_damped,
                             account.penetration, account.joint_work, account.way, account.impulse})
    if (!std::isfinite(value)) return false;
  return account.impulse_vector.allFinite();
}

bool is_finite_grip(const Grip& grip) {
  return std::isfinite(grip.work) && std::isfinite(grip.damped) && grip.start.allFinite() &&
         grip.end.allFinite() && grip.force.allFinite();
}

bool are_finite(const ContactSums& sums) {
  for (const double value :
       {sums.work, sums.lost, sums.friction_loss, sums.given, sums.error, sums.hand, sums.joint})
    if (!std::isfinite(value)) return false;
  return true;
}

}  // namespace

std::vector<std::byte> ContactBody::save() const {
  return save_body(*this);
}

Status ContactBody::restore(std::span<const std::byte> bytes) {
  return restore_body(*this, bytes);
}

std::uint64_t ContactBody::content_hash() const {
  if (!contact_) return Body::content_hash();
  std::string bytes;
  StateStream stream = StateStream::writing(bytes);
  std::uint64_t body = Body::content_hash();
  ContactLaw law = contact_->surface().law;
  std::vector<VertexId> ids = contact_->surface().points->ids;
  bool feels = contact_->surface().feels, shape = contact_->surface().shape.has_value();
  stream(body, law.margin, law.stiffness, law.friction, law.restitution, feels, shape);
  stream.sized(ids);
  return hash_bytes(std::as_bytes(std::span(bytes)));
}

void ContactBody::carry(StateStream& stream) {
  Body::carry(stream);
  // The method's step and damping are the body's.
  if (contact_ && stream.reads() && stream.good()) contact_->set_options(options_);
  stream(touched_, sound_touched_);
  if (stream.reads()) stream.require(are_finite(touched_) && are_finite(sound_touched_));
  carry_hands(stream);
  if (contact_) contact_->carry(stream);
  if (contact_ && stream.reads()) stream.require(is_finite_account(contact_->record().account));
  if (stream.reads())
    for (const Grip& grip : grips_) stream.require(is_finite_grip(grip));
}

void ContactBody::carry_hands(StateStream& stream) {
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
    tremolo::carry(stream, grips_[i], model().modes());
    stream(hands_[i]);
    const Result<VertexRows> vertex = model().vertex(grips_[i].vertex);
    grips_[i].at_vertex = vertex && vertex->rest == grips_[i].place.rest;
    stream.require(hands_[i] < next_hand_);
  }
}

Status ContactBody::set_damping(const DampingRatios& damping) {
  if (Status s = Body::set_damping(damping); !s) return s;
  if (contact_) contact_->set_options(options_);
  return Success{};
}

Status ContactBody::set_method(std::string_view integrator, double step) {
  if (contact_ && frame() != FrameKind::kFixed && !is_energy_method(integrator))
    return usage_error("contact goes with avf, ep2 and ep4");
  if (Status s = Body::set_method(integrator, step); !s) return s;
  if (contact_) contact_->set_options(options_);
  for (Grip& grip : grips_) limit_hand(grip);
  return Success{};
}

}  // namespace tremolo
