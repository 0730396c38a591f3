// ContactBody: its step, and the hands that hold it.
#include "runtime/contact_body.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <variant>

#include "common/mesh/tet_mesh.h"
#include "common/text.h"
#include "runtime/contact/islands/step_parts.h"
#include "runtime/contact/solve/contact_step.h"
#include "runtime/contact/solve/shape_reach.h"

namespace tremolo {
namespace {

// True if two colliders have the same shape and size.
struct SameShape {
  const Collider& other;

  bool operator()(const PlaneShape&) const { return true; }
  bool operator()(const SphereShape& shape) const {
    return shape.radius == std::get<SphereShape>(other).radius;
  }
  bool operator()(const CapsuleShape& shape) const { return same_sizes(shape); }
  bool operator()(const BoxShape& shape) const {
    return shape.half_extents == std::get<BoxShape>(other).half_extents;
  }
  bool operator()(const CylinderShape& shape) const { return same_sizes(shape); }
  bool operator()(const GridShape& shape) const {
    return shape.grid == std::get<GridShape>(other).grid;
  }
  template <class Shape>
  bool same_sizes(const Shape& shape) const {
    const Shape& its = std::get<Shape>(other);
    return shape.radius == its.radius && shape.half_length == its.half_length;
  }
};

// check_reach(), which skips the check for the shape that passed last: copies of a body share it.
Status check_reach_once(const Model::Pointer& model, const Collider& shape) {
  struct Good {
    std::weak_ptr<const Model> model;
    Collider shape;
  };
  static std::mutex mutex;
  static Good last;
  {
    const std::lock_guard hold(mutex);
    if (last.model.lock() == model && last.shape.index() == shape.index() &&
        std::visit(SameShape{last.shape}, shape))
      return Success{};
  }
  if (Status s = check_reach(*model, shape); !s) return s;
  const std::lock_guard hold(mutex);
  last = {model, shape};
  return Success{};
}

constexpr const char* kOnlyVertices = "a body on several bones is held at vertices only";

// The contact points with the weights of their vertices.
std::shared_ptr<BonePoints> points_on_bones(const Model& model, const Skin& skin,
                                            const ContactSurface& surface) {
  const ContactPoints& points = *surface.points;
  BoneWeights weights(std::ssize(points.ids), skin.surface.cols());
  for (Eigen::Index i = 0; i < weights.rows(); ++i) {
    const auto at = find_vertex(model.surface().vertex_ids, points.ids[i]);
    weights.row(i) = skin.surface.row(static_cast<Eigen::Index>(*at));
  }
  return std::make_shared<BonePoints>(points.rest, std::move(weights), points.field.softness2());
}

}  // namespace

Result<ContactBody> ContactBody::create(Model::Pointer model, std::string_view integrator,
                                        const IntegratorOptions& options, FrameKind frame) {
  Result<Body> body = Body::create(std::move(model), integrator, options, frame);
  if (!body) return body.error();
  return ContactBody(std::move(*body));
}

Result<ContactBody> ContactBody::create(Model::Pointer model, std::string_view integrator,
                                        const IntegratorOptions& options,
                                        std::shared_ptr<const Skin> skin) {
  Result<Body> body = Body::create(std::move(model), integrator, options, std::move(skin));
  if (!body) return body.error();
  return ContactBody(std::move(*body));
}

Status ContactBody::set_contact(const ContactOptions& options) {
  if (model_->inertia() == nullptr)
    return usage_error(
        "contact needs the inertia integrals, which this basis file has not; make it again with "
        "tremolo-precompute");
  if (options.points < 1 || !(options.margin > 0.0) || !(options.stiffness > 0.0) ||
      !std::isfinite(options.margin) || !std::isfinite(options.stiffness))
    return usage_error("contact needs at least one point, a margin and a stiffness above zero");
  if (options.modulus && !(*options.modulus > 0.0 && std::isfinite(*options.modulus)))
    return usage_error("contact needs a modulus above zero, in Pa");
  if (!(options.friction >= 0.0) || !std::isfinite(options.friction))
    return usage_error("a body's friction is " + number_text(options.friction) +
                       ", must be finite and not negative");
  if (!(options.restitution >= 0.0 && options.restitution <= 1.0))
    return usage_error("a body's restitution is " + number_text(options.restitution) +
                       ", must be from 0 to 1");
  if (options.shape)
    if (Status s = check(*options.shape); !s) return s;
  if (!has_energy_method() && frame() != FrameKind::kFixed)
    return usage_error("contact goes with avf, ep2 and ep4");
  if (!(bounding_box(model_->surface().rest).diagonal() > 0.0))
    return usage_error("contact needs a boundary of more than one vertex");
  if (options.shape)
    if (Status s = check_reach_once(model_, *options.shape); !s) return s;
  contact_ = std::make_shared<ContactStep>(
      model_, options_,
      make_contact_surface(model_, options, model_->inertia()->mass, frame() == FrameKind::kFree));
  if (bones() > 1) contact_->attach(points_on_bones(*model_, *skin(), contact_->surface()));
  return Success{};
}

ContactAccount ContactBody::contact_account() const {
  return contact_ ? contact_->record().account : ContactAccount{};
}

StepReport ContactBody::step(std::span<const PlacedCollider> colliders) {
  if (const std::optional<StepReport> failed = begin_step()) return *failed;
  return end_step(advance_near(near_something(colliders)));
}

// Takes the step with contact if something is near, or is found to have been near.
StepReport ContactBody::advance_near(bool near) {
  if (!near) {
    if (!contact_) return advance();
    contact_->reset();
    p_before_ = state_.p;
    const StepReport report = advance();
    if (!report.converged || !contact_->find_missed(step_end(), state_.q)) return report;
    take_back(p_before_);
  }
  if (model_->modes() == 0 && free_ && contact_->hits_hard(free_->rigid())) {
    const auto colliders = contact_->gathered().colliders;
    StepReport report = advance_in_parts({}, PartReason::kImpact);
    report.parts = 1;  // they are part of the plan
    if (booked_) return report;
    (void)near_something(colliders);
  }
  const StepReport report = contact_->step(state_, step_load_, free_.get(), false);
  if (!report.converged) return advance_in_parts(report, PartReason::kFailure);
  end_contact();
  return report;
}

// The core takes no parts: there a step in a hand that is not solved fails.
StepReport ContactBody::advance_in_parts(const StepReport& failure, PartReason reason) {
  StepReport report = failure;
  if constexpr (kHasColliders) {
    StepParts parts;
    const PartBody self{this, 0};
    booked_ = parts.step({{&self, 1}, contact_->gathered().colliders, {}, {}, nullptr},
                         options_.step, {&report, 1}, reason);
  }
  return report;
}

// All known forces of the next step.
StepPush ContactBody::step_push() const {
  StepPush push{&step_load_.average};
  if (!free_) return push;
  push.acceleration = gravity();
  return push;
}

void ContactBody::reserve_contact(std::span<const PlacedCollider> colliders, std::size_t hands) {
  if (!contact_) return;
  grips_.reserve(hands);
  grip_maps_.reserve(hands);
  hands_.reserve(hands);
  std::vector<Grip> all(hands);
  for (const std::span<Grip> held : {std::span(all), std::span<Grip>()})
    (void)contact_->gather(near(colliders, held), step_poses(), state_.q, state_.p, step_push());
}

// Finds the points that may be in contact in the step.
bool ContactBody::near_something(std::span<const PlacedCollider> colliders) {
  if (!contact_) return false;
  return contact_->gather(near(colliders, grips_), step_poses(), state_.q, state_.p, step_push());
}

// Places a body on several bones for its step, with its grabs.
ContactNear ContactBody::near(std::span<const PlacedCollider> colliders, std::span<Grip> grips) {
  if (!contact_->on_bones()) return {colliders, grips};
  contact_->place(*driven_);
  grip_maps_.resize(grips.size());
  for (std::size_t i = 0; i < grips.size(); ++i)
    if (const auto weights = weights_of(grips[i].vertex))
      grip_maps_[i] = contact_->equations().bones->maps_of(*weights);
  return {colliders, grips, grip_maps_};
}

std::optional<Eigen::Vector3d> PresentPlace::into_rest(const Eigen::Vector3d& x) const {
  if (!bones) return pose.rotation.conjugate() * (x - pose.position);
  const Eigen::Vector3d y = bones->into_rest(x, false);
  if (!bones->agree(x, y, false)) return std::nullopt;
  return y;
}

double PresentPlace::depth_in(const Collider& shape, const Eigen::Vector3d& x, double near) const {
  constexpr double kOutside = -std::numeric_limits<double>::infinity();
  if ((x - centre).norm() > radius + near) return kOutside;
  const std::optional<Eigen::Vector3d> y = into_rest(x);
  if (!y) return kOutside;
  if (points == nullptr) return -signed_distance(shape, *y).distance;
  return -bent_distance({&shape, points.get(), &displacement}, *y);
}

PresentPlace ContactBody::present_place() const {
  const ContactPoints& points = *contact_->surface().points;
  PresentPlace place{pose(), nullptr, pose() * points.centre, points.radius};
  if (!points.rigid() && !state_.q.isZero(0.0)) {
    place.radius += state_.q.cwiseAbs().dot(points.reach);
    place.points = contact_->surface().points;
    points.displacement(state_.q, place.displacement);
  }
  if (!contact_->on_bones()) return place;
  const double radius = place.radius;
  const auto bones = std::make_shared<BonePoints>(*contact_->equations().bones);
  bones->place(*driven_);
  for (const StepPoses& bone : bones->poses())
    place.radius =
        std::max(place.radius, radius + (bone.start * points.centre - place.centre).norm());
  place.bones = bones;
  return place;
}

Eigen::Vector3d ContactBody::contact_point(std::size_t point) const {
  const Eigen::Vector3d y = contact_->surface().points->place(point, state_.q);
  if (bones() < 2) return pose() * y;
  return blend(y, *weights_of(contact_->surface().points->ids[point]));
}

Eigen::Vector3d ContactBody::place_now(VertexId vertex, const VertexRows& place) const {
  const Eigen::Vector3d y = place.rest + place.rows * state_.q;
  if (bones() < 2) return pose() * y;
  const auto weights = weights_of(vertex);
  return weights ? blend(y, *weights) : Eigen::Vector3d(pose() * y);
}

// A position of the mesh's coordinates on the bones at their present poses.
Eigen::Vector3d ContactBody::blend(const Eigen::Vector3d& y,
                                   std::span<const double> weights) const {
  const BoneMap map = blended(weights, bone_maps());
  return map.leftCols<3>() * y + map.col(3);
}

// After a step with contact: resets the integrator, and each grab starts where it ended.
void ContactBody::end_contact() {
  integrator_->reset();
  for (Grip& grip : grips_) grip.start = grip.end;
}

// Adds contact's energies of a step, or of a part of it, to the sums.
void ContactBody::book_step(const StepReport& report) {
  const ContactAccount account = contact_account();
  touched_.hand += account.hand_work;
  touched_.joint += account.joint_work;
  touched_.work += account.work;
  touched_.lost += account.lost;
  touched_.friction_loss += account.friction_loss;
  touched_.given += account.given;
  touched_.error += account.surplus;
  const double kick = free_ ? 0.5 * account.impulse * account.impulse / free_->mass() : 0.0;
  // What rounding gives a body that stiff springs hold is no explosion.
  const double rounding = contact_ ? contact_->record().rounding : 0.0;
  Body::book_step(report, account.work + account.hand_work + account.joint_work,
                  std::max(kick, rounding));
}

StepReport ContactBody::end_step(StepReport report) {
  if (report.converged && !booked_) {
    book_step(report);
    booked_ = true;
  }
  report = Body::end_step(report, 0.0, booked_);
  if (!report.converged || place_forces_.none()) return report;
  for (std::size_t i = 0; i < grips_.size(); ++i) {
    const auto place = model().response_place(grips_[i].vertex);
    // A grab may be at a point of a triangle at the vertex.
    if (!place || !grips_[i].at_vertex) continue;
    place_forces_.push(*place, turn_at_place(*place).transpose() * hand_force(hands_[i]));
  }
  return report;
}

// Removes the motion of a body that falls asleep; contact takes its energy.
void ContactBody::fall_asleep() {
  const double taken = stop_motion();
  touched_.lost += taken;
  touched_.work -= taken;
  keep_sound_state();
}

Result<std::size_t> ContactBody::grab(VertexId vertex, double stiffness, double damping) {
  Result<VertexRows> place = model_->vertex(vertex);
  if (!place) return place.error();
  return grab(vertex, std::move(*place), stiffness, damping);
}

Result<std::size_t> ContactBody::grab(VertexId vertex, VertexRows place, double stiffness,
                                      double damping) {
  if (!contact_) return usage_error("hands need set_contact() first");
  if (!(stiffness >= 0.0) || !(damping >= 0.0) || !std::isfinite(stiffness) ||
      !std::isfinite(damping))
    return usage_error("a hand's stiffness and damping are finite and not negative");
  if (bones() > 1)
    if (const auto weights = weights_of(vertex); !weights) return weights.error();
  Grip grip{vertex, std::move(place), stiffness, damping};
  limit_hand(grip);
  grip.start = grip.end = place_now(vertex, grip.place);
  grips_.push_back(std::move(grip));
  hands_.push_back(next_hand_);
  return next_hand_++;
}

Result<std::size_t> ContactBody::grab(const SurfacePlace& place, double stiffness, double damping) {
  if (bones() > 1) return usage_error(kOnlyVertices);
  Result<VertexRows> rows = model_->place(place);
  if (!rows) return rows.error();
  const Result<std::size_t> hand =
      grab(model_->vertex_near(place), std::move(*rows), stiffness, damping);
  if (hand) find_hand(*hand)->at_vertex = false;
  return hand;
}

double ContactBody::mass_at(const VertexRows& place) const {
  const double h = options_.step;
  const Eigen::VectorXd& lambda = model_->lambda();
  double lightness = 0.0;
  for (Eigen::Index i = 0; i < lambda.size(); ++i)
    lightness += place.rows.col(i).squaredNorm() / (3.0 + 0.75 * h * h * lambda[i]);
  if (free_) {
    const std::shared_ptr<const FrameInertia> inertia = model_->inertia_about_centre();
    const Eigen::Matrix3d& P = inertia->P0;
    const Eigen::Matrix3d J = P.trace() * Eigen::Matrix3d::Identity() - P;
    const Eigen::Matrix3d arm = cross_matrix(place.rest + place.rows * state_.q - inertia->centre);
    lightness += 1.0 / inertia->mass - (arm * J.inverse() * arm).trace() / 3.0;
  }
  return 1.0 / lightness;
}

HandSpring ContactBody::stiffest_hand(const VertexRows& place) const {
  return stiffest_spring(mass_at(place), options_.step);
}

void ContactBody::limit_hand(Grip& grip) const {
  limit_spring(stiffest_hand(grip.place), options_.step, grip.stiffness, grip.damping);
}

Result<std::size_t> ContactBody::pin(VertexId vertex, VertexRows place) {
  const HandSpring pin = stiffest_hand(place);
  if (!std::isfinite(pin.stiffness))
    return usage_error("the place does not move: there is nothing to pin");
  return grab(vertex, std::move(place), pin.stiffness, pin.damping);
}

Result<std::size_t> ContactBody::pin(VertexId vertex) {
  Result<VertexRows> place = model_->vertex(vertex);
  if (!place) return place.error();
  return pin(vertex, std::move(*place));
}

Result<std::size_t> ContactBody::pin(const SurfacePlace& place) {
  if (bones() > 1) return usage_error(kOnlyVertices);
  Result<VertexRows> rows = model_->place(place);
  if (!rows) return rows.error();
  const Result<std::size_t> hand = pin(model_->vertex_near(place), std::move(*rows));
  if (hand) find_hand(*hand)->at_vertex = false;
  return hand;
}

const Grip* ContactBody::find_hand(std::size_t hand) const {
  const auto found = std::find(hands_.begin(), hands_.end(), hand);
  return found == hands_.end() ? nullptr : &grips_[found - hands_.begin()];
}

Grip* ContactBody::find_hand(std::size_t hand) {
  return const_cast<Grip*>(std::as_const(*this).find_hand(hand));
}

Status ContactBody::move_hand(std::size_t hand, const Eigen::Vector3d& place) {
  Grip* grip = find_hand(hand);
  if (grip == nullptr) return usage_error("there is no hand " + std::to_string(hand));
  if (!place.allFinite()) return usage_error("the hand's place is not finite");
  grip->end = place;
  return Success{};
}

Eigen::Vector3d ContactBody::hand_force(std::size_t hand) const {
  const Grip* grip = find_hand(hand);
  return grip == nullptr ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : grip->force;
}

HandSpring ContactBody::hand_spring(std::size_t hand) const {
  const Grip* grip = find_hand(hand);
  return grip == nullptr ? HandSpring{} : HandSpring{grip->stiffness, grip->damping};
}

Status ContactBody::release(std::size_t hand) {
  const Grip* grip = find_hand(hand);
  if (grip == nullptr) return usage_error("there is no hand " + std::to_string(hand));
  const auto at = grip - grips_.data();
  grips_.erase(grips_.begin() + at);
  hands_.erase(hands_.begin() + at);
  return Success{};
}

}  // namespace tremolo
