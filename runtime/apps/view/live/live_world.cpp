#include "runtime/apps/view/live/live_world.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <Eigen/Eigenvalues>

#include "common/text.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/start/start_state.h"
#include "runtime/contact/springs.h"
#include "runtime/scene/scene_start.h"

namespace tremolo {

HandSpring suitable_springs(const ContactBody& body, const VertexRows& place) {
  // Compliance of the vertex at rest, m/N; its inverse mass, 1/kg, is below.
  const Eigen::Matrix3d give =
      place.rows * body.model().lambda().cwiseInverse().asDiagonal() * place.rows.transpose();
  const double most = give.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff();
  const double inverse_mass =
      Eigen::Matrix3d(place.rows * place.rows.transpose()).diagonal().mean();
  if (body.frame() == FrameKind::kFree && body.model().inertia() != nullptr)
    return swinging_spring(body.model().inertia()->mass);
  return pulling_spring(most, 1.0 / std::max(inverse_mass, 1e-30));
}

namespace {

// Numbers that are written with few digits, so that a record of them says the same.
HandSpring written_springs(HandSpring springs, double firmness) {
  for (double* number : {&springs.stiffness, &springs.damping})
    *number = std::stod(number_text(*number * firmness));
  return springs;
}

}  // namespace

std::string LiveHand::name(const SceneWorld& world) const {
  return guest_ ? guest_->guests->name(guest_->guest) : world.name(body_);
}

void LiveHand::make_holdable(SceneWorld& world) {
  for (std::size_t i = 0; i < world.size(); ++i) {
    ContactBody& body = world.body(i);
    if (body.contact() == nullptr) {
      // As the scene would if it had the hand.
      ContactOptions contact = world.scene().bodies[i].contact;
      contact.colliders = world.scene().bodies[i].feels_contact;
      // For a body that cannot be grabbed the error is reported when the user tries.
      (void)body.set_contact(contact);
    }
    if (body.contact() != nullptr) body.reserve_contact(world.colliders(), 2);
  }
}

Status LiveHand::take(SceneWorld& world, const SceneWorld::Hit& hit, double firmness) {
  let_go(world);
  ContactBody& body = world.body(hit.body);
  const auto refused = [&](const std::string& why) {
    return usage_error(world.name(hit.body) + ": " + why);
  };
  Result<VertexRows> place = body.model().vertex(hit.hit.vertex);
  if (!place) return refused(place.error().message);
  if (body.frame() != FrameKind::kFree && place->rows.isZero(0.0))
    return refused("vertex " + std::to_string(hit.hit.vertex) + " does not move, it is fixed");
  if (body.contact() == nullptr) {
    const Status why = body.set_contact();
    return refused("no hand holds it: " + (why ? "it was made without" : why.error().message));
  }
  body_ = hit.body;
  vertex_ = hit.hit.vertex;
  place_ = std::move(*place);
  springs_ = written_springs(suitable_springs(body, place_), firmness);
  begun_ = held(world);
  way_.setZero();
  const Result<std::size_t> number =
      body.grab(vertex_, place_, springs_.stiffness, springs_.damping);
  if (!number) return refused(number.error().message);
  number_ = *number;
  return Success{};
}

Status LiveHand::take(SceneWorld& world, const LiveGuests& guests, const LiveGuests::Hit& hit,
                      double firmness) {
  let_go(world);
  const Result<HandSpring> springs = guests.suitable_springs(hit);
  if (!springs) return usage_error(guests.name(hit.guest) + ": " + springs.error().message);
  MixedGuests& all = guests.all();
  std::size_t point = all.point_near(hit.guest, guests.vertex_at(hit.guest, hit.vertex));
  vertex_ = all.number_of(hit.guest, point);
  // A scene names a vertex, not the middle of an edge, and of a mesh one of the file.
  if (const ClothStep* cloth = all.cloth(hit.guest)) {
    const ClothParts& parts = cloth->body().model().parts();
    for (std::size_t v = parts.vertices(); v-- > 0;)
      if (parts.particle_of_vertex(v) == point) vertex_ = static_cast<VertexId>(v);
  } else if (const Result<std::size_t> named = all.point_of_vertex(hit.guest, vertex_)) {
    point = *named;
  }
  springs_ = written_springs(*springs, firmness);
  const HandSpring most = all.stiffest_hand(hit.guest, point);
  limit_spring(most, world.step_size(), springs_.stiffness, springs_.damping);
  GuestHold taken{&all, hit.guest, point, 0};
  if (Status s = tremolo::take(taken.number, all.hold(taken.guest, taken.point, springs_)); !s)
    return s;
  guest_ = taken;
  begun_ = held(world);
  way_.setZero();
  return Success{};
}

Eigen::Vector3d LiveHand::held(const SceneWorld& world) const {
  if (guest_) return guest_->guests->point_at(guest_->guest, guest_->point);
  const ContactBody& body = world.body(body_);
  return body.place_now(vertex_, place_);
}

void LiveHand::before_step(SceneWorld& world) {
  // The number is valid, since the body returned it, and the point is finite.
  if (number_) (void)world.body(body_).move_hand(*number_, point());
  if (guest_) (void)guest_->guests->move_hand(guest_->number, point());
}

void LiveHand::let_go(SceneWorld& world) {
  if (number_) (void)world.body(body_).release(*number_);
  number_.reset();
  if (guest_) guest_->guests->let_go(guest_->number);
  guest_.reset();
}

namespace {

// The body's loads at t = 0, r.
Result<Eigen::VectorXd> push_at_start(const SceneBody& wanted, const ContactBody& body) {
  Eigen::VectorXd push = Eigen::VectorXd::Zero(body.model().modes());
  for (const SceneLoad& load : wanted.loads) {
    Signal signal = load.signal;
    signal.table = load.table.get();
    const Result<DefaultLoad> forces = forces_of(load, body.model());
    if (!forces) return forces.error();
    const Result<Eigen::VectorXd> reduced =
        reduce_load(body.model(), *forces, sample_signal(signal, 0.0, body.options().step).start);
    if (!reduced) return reduced.error();
    push += *reduced;
  }
  return push;
}

Status start_body(const SceneBody& wanted, const std::string& start, ContactBody& body) {
  if (start.empty()) return Success{};
  const Result<Eigen::VectorXd> push = push_at_start(wanted, body);
  if (!push) return push.error();
  const Result<State> state = start_state(start, body.model(), *push);
  if (!state) return state.error();
  return body.set_state(state->q, state->p);
}

}  // namespace

Result<LiveWorld> LiveWorld::create(const ViewedScene& viewed, ModelCache& models) {
  LiveWorld course;
  course.viewed_ = viewed;
  if (Status s = course.begin(models); !s)
    return error_of_file(viewed.file, value_error(s.error()));
  return course;
}

Status LiveWorld::begin_again(ModelCache& models) {
  viewed_.scene.step = world_->step_size();
  for (std::size_t i = 0; i < world_->size(); ++i) {
    SceneBody& body = viewed_.scene.bodies[i];
    body.integrator = world_->body(i).integrator().name();
    body.options.alpha = world_->body(i).options().alpha;
    body.options.beta = world_->body(i).options().beta;
    body.options.ratios = world_->body(i).options().ratios;
  }
  return begin(models);
}

Status LiveWorld::begin(ModelCache& models) {
  Result<SceneWorld> world =
      SceneWorld::create(viewed_.scene, models.source(), viewed_.has_guests());
  if (!world) return world.error();
  WorldGuests guests;
  if (viewed_.has_guests())
    if (Status s =
            tremolo::take(guests, add_guests(viewed_.tets, viewed_.cloths, viewed_.file, *world));
        !s)
      return s;
  world_ = std::make_unique<SceneWorld>(std::move(*world));
  guests_ = LiveGuests(std::move(guests));
  hand_ = LiveHand();
  trouble_.clear();
  trouble_code_ = 0;
  LiveHand::make_holdable(*world_);
  for (std::size_t i = 0; i < world_->size(); ++i)
    if (Status s = start_body(viewed_.scene.bodies[i], viewed_.starts[i], world_->body(i)); !s)
      return s;
  held_.clear();
  for (std::size_t i = 0; i < viewed_.scene.hands.size(); ++i) {
    held_.emplace_back();
    if (world_->guest_vertex(i)) continue;
    const ContactBody& body = world_->body(*world_->find(viewed_.scene.hands[i].body));
    if (Status s = tremolo::take(held_.back(), body.model().vertex(world_->hand(i).vertex())); !s)
      return s;
  }
  return refresh();
}

Status LiveWorld::look(WorldMoment& moment) const {
  if (Status s = look_at_world(*world_, guests_, moment); !s) return s;
  moment.hands.resize(held_.size() + 1);
  for (std::size_t i = 0; i < held_.size(); ++i) {
    HandMoment& hand = moment.hands[i];
    hand.holds = world_->hand(i).holds();
    if (const std::optional<Eigen::Vector3d> vertex = world_->guest_vertex(i)) {
      hand.held = *vertex;
    } else {
      const ContactBody& body = world_->body(*world_->find(viewed_.scene.hands[i].body));
      hand.held = body.place_now(world_->hand(i).vertex(), held_[i]);
    }
    hand.point = hand.held;  // a scene's hand does not say where it is
  }
  HandMoment& mine = moment.hands.back();
  mine.holds = hand_.holds();
  if (!mine.holds) return Success{};
  mine.held = hand_.held(*world_);
  mine.point = hand_.point();
  return Success{};
}

Status LiveWorld::refresh() {
  if (Status s = look(moments_[newest_]); !s) return s;
  moments_[1 - newest_] = moments_[newest_];
  return Success{};
}

Result<std::optional<Eigen::Vector3d>> LiveWorld::take(const CameraRay& ray, double firmness) {
  const Result<std::optional<SceneWorld::Hit>> hit = world_->pick(ray.origin, ray.direction);
  if (!hit) return hit.error();
  const std::optional<LiveGuests::Hit> guest = guests_.pick(ray);
  if (guest && (!*hit || guest->distance < (*hit)->hit.distance)) {
    if (Status s = hand_.take(*world_, guests_, *guest, firmness); !s) return s.error();
    return std::optional<Eigen::Vector3d>(ray.origin + guest->distance * ray.direction);
  }
  if (!*hit) return std::optional<Eigen::Vector3d>();
  if (Status s = hand_.take(*world_, **hit, firmness); !s) return s.error();
  return std::optional<Eigen::Vector3d>((*hit)->hit.point);
}

// from: time at which the step began, s.
void LiveWorld::note_trouble(std::span<const SceneWorld::Failure> failures, double from) {
  if (!trouble_.empty()) return;
  if (!failures.empty()) {
    const auto& [body, report] = failures.front();
    trouble_ =
        "body '" + world_->name(body) + "': " + failure_message(report, world_->body(body).time());
    trouble_code_ = exit_code(error_kind(report.failure));
  }
  for (std::size_t i = 0; i < guests_.size() && trouble_.empty(); ++i) {
    if (!guests_.failed(i)) continue;
    trouble_ = "body '" + guests_.name(i) + "': the step from t = " + number_text(from) +
               " s could not be solved: take a shorter step";
    trouble_code_ = exit_code(ErrorKind::kSolver);
  }
}

Status LiveWorld::step() {
  const double from = world_->time();
  hand_.before_step(*world_);
  note_trouble(world_->step(), from);
  newest_ = 1 - newest_;
  return look(moments_[newest_]);
}

void LiveWorld::at(double t, WorldMoment& out) const {
  const double step = now().time - before().time;
  const double share = step > 0.0 ? std::clamp((t - before().time) / step, 0.0, 1.0) : 1.0;
  between(before(), now(), share, out);
}

}  // namespace tremolo
