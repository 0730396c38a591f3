#include "runtime/world/scene_world.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <map>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>

#include "common/overflow.h"
#include "common/text.h"
#include "runtime/contact/collider.h"
#include "runtime/contact/solve/contact_step.h"
#include "runtime/scene/scene_start.h"
#include "runtime/scene/world_anchor.h"
#include "runtime/world/near_balls.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

Error error_of_body(const SceneBody& body, Error error) {
  error.message = "body '" + body.name + "': " + error.message;
  return error;
}

// The farthest that a point of the model is from its frame's origin at rest, m.
double reach_of(const Model& model) {
  double reach = 0.0;
  for (const Vector3d& x : model.surface().rest) reach = std::max(reach, x.norm());
  return reach;
}

// Bodies with the same key share a model.
std::string key_of(const SceneBody& body) {
  if (!body.rigid) {
    const ModelOptions& options = body.model_options;
    return "|" + std::to_string(options.modes) + (options.linear ? "l" : "-") +
           (options.hull ? "h" : "-") + "|" + body.model;
  }
  const RigidSolid& solid = *body.rigid;
  std::string key = solid.mesh + "|" + std::to_string(body.contact.points);
  const auto add = [&key](std::initializer_list<double> values) {
    for (const double& value : values)
      key.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  if (solid.shape) {
    key += shape_name(*solid.shape);
    const BoundingBox box = bounds(*solid.shape);
    add({box.high.x(), box.high.y(), box.high.z()});
  }
  add({solid.mass.value_or(-1.0), solid.density.value_or(-1.0)});
  if (solid.inertia) add({solid.inertia->x(), solid.inertia->y(), solid.inertia->z()});
  return key;
}

Pose unit(const Pose& pose) {
  return {pose.position, pose.rotation.normalized()};
}

}  // namespace

Result<Model::Pointer> load_scene_model(const SceneBody& body) {
  if (body.rigid) return make_rigid_model(*body.rigid, body.contact.points);
  std::error_code ignored;
  if (!std::filesystem::exists(body.model, ignored)) {
    const std::string usual = "tremolo-precompute MESH -o " + body.model +
                              (body.kind == FrameKind::kFree ? " --fix none" : " --fix SELECTOR");
    return system_error(body.model + ": there is no such basis file; make it with `" +
                        (body.made_by.empty() ? usual : body.made_by) + "`");
  }
  return Model::load(body.model, body.model_options);
}

Result<SceneWorld> SceneWorld::create(const Scene& scene, const ModelSource& source, bool guests) {
  if (Status s = check_scene(scene); !s) return s.error();
  SceneWorld world(scene);
  const std::vector<Vector3d>& values = world.scene_.gravity.values;
  world.gravity_changes_ = values.size() > 1;
  std::map<std::string, Model::Pointer> models;
  for (SceneBody& wanted : world.scene_.bodies) {
    Model::Pointer& model = models[key_of(wanted)];
    if (!model)
      if (Status s = take(model, wanted.rigid ? load_scene_model(wanted) : source(wanted)); !s)
        return error_of_body(wanted, s.error());
    if (wanted.rig)
      if (Status s = take_rig(wanted, *model); !s) return error_of_body(wanted, s.error());
    Result<Actor> actor = world.make(wanted, model);
    if (!actor) return error_of_body(wanted, actor.error());
    world.actors_.push_back(std::move(*actor));
  }
  if (Status s = take(world.colliders_, SceneColliders::create(world.scene_)); !s) return s.error();
  for (std::size_t i = 0; i < world.size(); ++i) world.numbers_[world.name(i)] = i;
  world.list_passing();
  const ContactNeeds needs(world.scene_);
  for (std::size_t i = 0; i < world.size(); ++i) {
    const SceneBody& wanted = world.scene_.bodies[i];
    if (Status s = world.begin_contact(i, needs.of(wanted) || (guests && wanted.feels_contact)); !s)
      return error_of_body(wanted, s.error());
  }
  if (Status s = world.check_apart(); !s) return s.error();
  if (Status s = world.add_hands(); !s) return s.error();
  world.shapes_.clear();
  world.group_ = std::make_unique<BodyGroup>(BodyGroup::Options{.sleep = scene.sleep});
  world.order_.resize(world.size());
  std::iota(world.order_.begin(), world.order_.end(), std::size_t{0});
  std::sort(world.order_.begin(), world.order_.end(),
            [&world](std::size_t a, std::size_t b) { return world.name(a) < world.name(b); });
  world.place_.resize(world.size());
  for (std::size_t k = 0; k < world.size(); ++k) world.place_[world.order_[k]] = k;
  world.stepped_.resize(world.size());
  if (Status s = world.add_anchors(); !s) return s.error();
  world.reports_.resize(world.stepped_.size());
  world.failures_.reserve(world.actors_.size());
  if (Status s = world.add_joints(); !s) return s.error();
  return world;
}

Result<SceneWorld::Actor> SceneWorld::make(const SceneBody& wanted, Model::Pointer model) const {
  IntegratorOptions options = wanted.options;
  options.step = scene_.step;
  const double reach = reach_of(*model);
  std::shared_ptr<const Skin> skin;
  if (!wanted.bones.empty())
    if (Status s = take(skin, make_scene_skin(wanted, *model)); !s) return s.error();
  Result<ContactBody> body =
      skin ? ContactBody::create(std::move(model), wanted.integrator, options, std::move(skin))
           : ContactBody::create(std::move(model), wanted.integrator, options, frame_kind(wanted));
  if (!body) return body.error();
  Result<MotionPath> path = MotionPath::create(wanted.motion, unit(wanted.pose));
  if (!path) return path.error();
  if (Status s = check_accelerations(wanted, *path, scene_, reach); !s) return s.error();
  Actor actor{std::move(*body), std::move(*path), nullptr};
  if (actor.body.model().inertia() != nullptr)
    actor.inertia = actor.body.model().inertia_about_origin();
  if (!wanted.bones.empty()) {
    Result<BonePaths> bones = BonePaths::create(wanted);
    if (!bones) return bones.error();
    actor.bones = std::move(*bones);
    if (Status s = check_bone_accelerations(wanted, *actor.bones, scene_, reach); !s)
      return s.error();
  }
  if (const InertiaIntegrals* inertia = actor.body.model().inertia())
    if (Status s = check_scale({.mass = inertia->mass,
                                .reach = wanted.pose.position.norm() + reach,
                                .speed = wanted.velocity.norm() + reach * wanted.spin.norm(),
                                .gravity = scene_.gravity.at(0.0).norm(),
                                .step = scene_.step});
        !s)
      return s.error();
  if (Status s = begin(wanted, actor); !s) return s.error();
  actor.energy_at_start = actor.body.energy().total();
  return actor;
}

Status SceneWorld::begin(const SceneBody& wanted, Actor& actor) const {
  ContactBody& body = actor.body;
  if (body.frame() != FrameKind::kFixed) {
    actor.piece = actor.path.piece(0.5 * scene_.step);
    const Pose pose = actor.path.pose_in(actor.piece, 0.0);
    if (Status s = body.set_pose(pose); !s) return s;
    if (body.frame() == FrameKind::kFree)
      if (Status s = body.set_motion(wanted.velocity, pose.rotation.conjugate() * wanted.spin); !s)
        return s;
  }
  if (actor.bones) {
    std::vector<Pose> poses(actor.bones->size());
    actor.bones->poses(0.0, poses);
    for (std::size_t b = 0; b < poses.size(); ++b)
      if (Status s = body.set_pose(poses[b], b); !s) return s;
  }
  // A body computes integrals for gravity when it first gets some, which must not happen inside a
  // step.
  for (const Vector3d& value : scene_.gravity.values)
    if (Status s = body.set_gravity(value); !s) return s;
  const Vector3d gravity = scene_.gravity.at(0.0);
  if (Status s = body.set_gravity(gravity); !s) return s;
  if (Status s = add_loads(wanted.loads, body); !s) return s;
  return wanted.settled ? settle(wanted, gravity, body) : Status(Success{});
}

std::span<const PlacedCollider> SceneWorld::felt_by(std::size_t i) const {
  return scene_.bodies[i].feels_contact ? colliders_.placed() : std::span<const PlacedCollider>{};
}

Result<ContactOptions> SceneWorld::contact_of(const SceneBody& wanted) {
  ContactOptions contact = wanted.contact;
  contact.colliders = wanted.feels_contact;
  if (wanted.rigid && wanted.rigid->shape) contact.shape = wanted.rigid->shape;
  if (wanted.shape_file.empty()) return contact;
  auto found = shapes_.find(wanted.shape_file);
  if (found == shapes_.end()) {
    Result<std::optional<Collider>> shape = load_body_shape(wanted);
    if (!shape) return shape.error();
    found = shapes_.emplace(wanted.shape_file, **shape).first;
  }
  contact.shape = found->second;
  return contact;
}

// No body begins inside another one.
Status SceneWorld::check_apart() const {
  if (!bodies_touch(scene_)) return Success{};
  NearBalls near;
  for (std::size_t i = 0; i < size(); ++i) {
    if (!scene_.bodies[i].feels_contact) continue;
    const PresentPlace place = actors_[i].body.present_place();
    near.add(i, place.centre, place.radius);
  }
  near.sort();
  for (std::size_t a = 0; a < size(); ++a)
    for (const std::size_t b : near.of(a)) {
      if (passes_through(a, b)) continue;
      const ContactBody& other = actors_[b].body;
      const double depth = depth_in_body(actors_[a].body, other, other.present_place());
      const double margin = actors_[a].body.contact()->surface().law.margin;
      if (depth > margin)
        return content_error("body '" + name(a) + "': it begins " + number_text(depth) +
                             " m inside body '" + name(b) + "', more than its contact-margin of " +
                             number_text(margin) + " m: put one of them elsewhere");
    }
  return Success{};
}

// Makes the body feel colliders and hands. It must not begin inside a collider.
Status SceneWorld::begin_contact(std::size_t i, bool needed) {
  const SceneBody& wanted = scene_.bodies[i];
  Actor& actor = actors_[i];
  if (!needed) return Success{};
  const Result<ContactOptions> contact = contact_of(wanted);
  if (!contact) return contact.error();
  if (Status s = actor.body.set_contact(*contact); !s)
    return content_error("contact: " + s.error().message);
  actor.size = actor.body.contact()->surface().points->extent;
  const auto felt = felt_by(i);
  const double margin = actor.body.contact()->surface().law.margin;
  if (const DeepestPoint deepest = deepest_point(actor.body, felt);
      deepest.depth > margin && !replaying_)
    return content_error(
        "it begins " + number_text(deepest.depth) + " m (" +
        number_text(100.0 * deepest.depth / actor.size) + " % of its size) inside collider '" +
        scene_.colliders[deepest.collider].name + "', more than its contact-margin of " +
        number_text(margin) + " m: put one of them elsewhere");
  actor.begins_within = begins_within_margin(actor.body, felt);
  const std::string& name = wanted.name;
  const auto hands = std::count_if(scene_.hands.begin(), scene_.hands.end(),
                                   [&name](const SceneHand& hand) { return hand.body == name; });
  actor.body.reserve_contact(felt, static_cast<std::size_t>(hands));
  touching_.resize(size() * colliders_.placed().size());
  events_.reserve(touching_.size());
  return Success{};
}

// Those on bodies of other kinds follow with the guests.
Status SceneWorld::add_hands() {
  own_hands_.resize(scene_.hands.size());
  for (std::size_t i = 0; i < scene_.hands.size(); ++i) {
    const std::optional<std::size_t> body = find(scene_.hands[i].body);
    if (!body) continue;
    Result<MovingHand> hand = MovingHand::create(scene_.hands[i], actors_[*body].body);
    if (!hand) return error_of_listed("hand", i, scene_.hands[i], hand.error());
    own_hands_[i] = hands_.size();
    hands_.push_back({std::move(*hand), *body, i});
  }
  return Success{};
}

Status SceneWorld::add_anchors() {
  anchor_of_.resize(scene_.joints.size());
  for (std::size_t i = 0; i < scene_.joints.size(); ++i) {
    if (!scene_.joints[i].to.empty()) continue;
    anchor_of_[i] = anchors_.size();
    if (Status s = add_anchor(); !s) return s;
  }
  return Success{};
}

Status SceneWorld::add_anchor() {
  Result<ContactBody> anchor = make_world_anchor(scene_.step);
  if (!anchor) return anchor.error();
  anchors_.push_back(std::move(*anchor));
  anchor_numbers_.push_back(new_number(kNobody));
  return Success{};
}

// Those of a pair in the scene's order.
Status SceneWorld::add_joints() {
  own_joints_.resize(scene_.joints.size());
  const JointLoads loads = joint_loads();
  for (std::size_t i = 0; i < scene_.joints.size(); ++i) {
    const std::optional<std::size_t> a = find(scene_.joints[i].body), b = find(scene_.joints[i].to);
    if (!a || (!b && !anchor_of_[i])) continue;
    const ContactBody& other = b ? actors_[*b].body : anchor(i);
    if (Status s = begin_joint(i, loads.of(i), *a, other, b ? place_[*b] : anchor_number(i)); !s)
      return s;
  }
  return Success{};
}

// Of the joints of the scene as it is now.
JointLoads SceneWorld::joint_loads() const {
  return JointLoads(scene_.joints, [this](const std::string& name) {
    CarriedBody carried;
    const std::optional<std::size_t> i = find(name);
    if (!i || actors_[*i].body.frame() != FrameKind::kFree) return carried;
    carried.moves = true;
    carried.mass = actors_[*i].body.model().inertia()->mass;
    carried.supported = std::any_of(scene_.hands.begin(), scene_.hands.end(),
                                    [&name](const SceneHand& hand) { return hand.body == name; });
    return carried;
  });
}

// Joint i of the scene, between body a and another one, whose number in the group is `there`.
Status SceneWorld::begin_joint(std::size_t i, double load, std::size_t a, const ContactBody& other,
                               std::size_t there) {
  SceneJoint loaded = scene_.joints[i];
  loaded.options.load = load;
  Result<HeldJoint> joint = HeldJoint::create(loaded, actors_[a].body, other);
  if (!joint) return error_of_listed("joint", i, scene_.joints[i], joint.error());
  joint->begin(*group_, place_[a], there);
  own_joints_[i] = joints_.size();
  joints_.push_back({std::move(*joint), place_[a], there, i});
  return Success{};
}

bool SceneWorld::passes_through(std::size_t a, std::size_t b) const {
  return passing_.contains(std::minmax(a, b));
}

void SceneWorld::list_passing() {
  for (const SceneJoint& joint : scene_.joints) {
    const auto a = find(joint.body), b = find(joint.to);
    if (!joint.options.touch && a && b) passing_.insert(std::minmax(*a, *b));
  }
}

double SceneWorld::contact_speed_limit() const {
  double least = std::numeric_limits<double>::infinity();
  const auto look_at = [&least](const Collider& shape) {
    if (const double way = least_passage(shape); way > 0.0) least = std::min(least, way);
  };
  for (const PlacedCollider& collider : colliders_.placed()) look_at(collider.shape);
  for (const Actor& actor : actors_)
    if (actor.body.contact() != nullptr && actor.body.contact()->surface().shape)
      look_at(*actor.body.contact()->surface().shape);
  return least / scene_.step;
}

Result<Model::Pointer> SceneWorld::model_of(const SceneBody& wanted,
                                            const ModelSource& source) const {
  const std::string key = key_of(wanted);
  for (std::size_t i = 0; i < size(); ++i)
    if (!removed(i) && key_of(scene_.bodies[i]) == key)
      return actors_[i].body.model().shared_from_this();
  return wanted.rigid ? load_scene_model(wanted) : source(wanted);
}

std::optional<std::size_t> SceneWorld::find(std::string_view name) const {
  const auto found = numbers_.find(std::string(name));
  return found == numbers_.end() ? std::nullopt : std::optional(found->second);
}

Status SceneWorld::add_load(std::size_t i, const SceneLoad& load, const DefaultLoad& forces) {
  Signal signal = load.signal;
  signal.table = load.table.get();
  if (Status s = actors_[i].body.add_load(signal, forces); !s) return s;
  scene_.bodies[i].loads.push_back(load);
  return Success{};
}

Status SceneWorld::start_at(std::size_t i, const State& state) {
  Actor& actor = actors_[i];
  if (Status s = actor.body.set_state(state.q, state.p); !s) return s;
  actor.energy_at_start = actor.body.energy().total();
  return Success{};
}

// Damping that begins at the step.
Status SceneWorld::damp(std::size_t i) {
  const SceneBody& wanted = scene_.bodies[i];
  ContactBody& body = actors_[i].body;
  const auto now = [this](const std::vector<ValueFrom>& course, double before) {
    for (const ValueFrom& from : course)
      if (from.time <= time() + kSameTime * scene_.step) before = from.value;
    return before;
  };
  return body.set_damping(now(wanted.alphas, body.options().alpha),
                          now(wanted.betas, body.options().beta));
}

// Poses of a path are finite with quaternions of unit length: the call cannot fail.
void SceneWorld::move_bones(Actor& actor) const {
  const BonePaths::Step step = actor.bones->step(steps_, scene_.step);
  for (std::size_t b = 0; b < actor.bones->size(); ++b)
    (void)actor.body.move_to(step.end[b], step.motion(b, scene_.step), b);
}

void SceneWorld::move_frame(Actor& actor) const {
  if (actor.bones) return move_bones(actor);
  if (actor.given) {
    // The pose was checked when it was given.
    (void)actor.body.move_to(*actor.given);
    return;
  }
  if (actor.path.still()) return;
  const double h = scene_.step, t = time();
  const std::size_t piece = actor.path.piece(t + 0.5 * h);
  // Poses of a path are finite with quaternions of unit length: neither call can fail.
  if (piece != actor.piece) (void)actor.body.set_pose(actor.path.pose_in(piece, t));
  actor.piece = piece;
  (void)actor.body.move_to(actor.path.pose_in(piece, static_cast<double>(steps_ + 1) * h),
                           frame_motion(actor.path, piece, steps_, h));
}

void SceneWorld::move_hands() {
  for (Hand& hand : hands_) {
    Actor& actor = actors_[hand.body];
    // The hand was checked when it was made: the body takes it.
    if (!actor.failed && !hand.over)
      (void)hand.hand.before_step(scene_.hands[hand.wanted], steps_, scene_.step, actor.body);
  }
}

Status SceneWorld::set_method(std::size_t i, std::string_view integrator) {
  ContactBody& body = actors_[i].body;
  if (Status s = body.set_method(integrator, scene_.step); !s)
    return error_of_body(scene_.bodies[i], s.error());
  scene_.bodies[i].integrator = body.integrator().name();
  return Success{};
}

Status SceneWorld::set_step(double step) {
  if (!(step > 0.0) || !std::isfinite(step))
    return usage_error("a step must be positive and finite, got " + number_text(step) + " s");
  if (guests_) return usage_error("the step of a world with bodies of other kinds is fixed");
  for (std::size_t i = 0; i < size(); ++i) {
    ContactBody& body = actors_[i].body;
    if (const Status s = body.set_method(body.integrator().name(), step); !s) {
      // The step that was there was good for all of them.
      for (std::size_t k = 0; k < i; ++k)
        (void)actors_[k].body.set_method(actors_[k].body.integrator().name(), scene_.step);
      return error_of_body(scene_.bodies[i], s.error());
    }
  }
  for (ContactBody& anchor : anchors_)
    if (Status s = anchor.set_method(anchor.integrator().name(), step); !s) return s;
  steps_ = std::llround(time() / step);
  scene_.step = step;
  return Success{};
}

std::span<const SceneWorld::Failure> SceneWorld::step() {
  failures_.clear();
  events_.clear();
  // One body that nothing touches, moves or holds steps by itself: groups cost it a fifth of a
  // microsecond.
  if (actors_.size() == 1 && !guests_ && !gravity_changes_ && !actors_[0].failed &&
      colliders_.placed().empty()) {
    Actor& only = actors_[0];
    const SceneBody& wanted = scene_.bodies[0];
    if (only.body.contact() == nullptr && only.path.still() && !only.given && !only.bones &&
        wanted.alphas.empty() && wanted.betas.empty()) {
      ++steps_;
      const StepReport report = only.body.step({});
      if (report.converged) return failures_;
      only.failed = true;
      failures_.push_back({0, report});
      return failures_;
    }
  }
  if (colliders_.move(steps_, scene_.step)) wake_all();
  move_hands();
  for (JointOf& joint : joints_)
    joint.joint.before_step(scene_.joints[joint.wanted], time(), scene_.step, *group_);
  if (links_) links_->before_step(steps_);
  const Vector3d gravity = scene_.gravity.at(time() + 0.5 * scene_.step);
  if (gravity_changes_ && guests_) guests_->set_gravity(gravity);
  for (std::size_t i = 0; i < actors_.size(); ++i) {
    Actor& actor = actors_[i];
    actor.old = actor.removed;
    stepped_[place_[i]] = actor.failed ? nullptr : &actor.body;
    if (actor.failed) continue;
    if (gravity_changes_) (void)actor.body.set_gravity(gravity);
    // Its values were checked when the world was made.
    if (!scene_.bodies[i].alphas.empty() || !scene_.bodies[i].betas.empty()) (void)damp(i);
    move_frame(actor);
  }
  for (std::size_t k = 0; k < anchors_.size(); ++k) stepped_[anchor_numbers_[k]] = &anchors_[k];
  group_->step(stepped_, colliders_.placed(), reports_);
  for (std::size_t i = 0; i < actors_.size(); ++i) {
    if (actors_[i].failed) continue;
    const StepReport& report = reports_[place_[i]];
    if (report.converged) {
      note_contact(i);
      continue;
    }
    actors_[i].failed = true;
    failures_.push_back({i, report});
  }
  note_pairs();
  ++steps_;
  return failures_;
}

Result<std::optional<SceneWorld::Hit>> SceneWorld::pick(const Vector3d& origin,
                                                        const Vector3d& direction,
                                                        SurfaceKind surface) const {
  std::optional<Hit> nearest;
  for (std::size_t i = 0; i < size(); ++i) {
    if (removed(i)) continue;
    const auto found = actors_[i].body.pick(origin, direction, surface);
    if (!found) return error_of_body(scene_.bodies[i], found.error());
    if (*found && (!nearest || (*found)->distance < nearest->hit.distance))
      nearest = Hit{i, **found};
  }
  return nearest;
}

}  // namespace tremolo
