// C structs to values of a scene: bodies, colliders, joints and loads.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "common/overflow.h"
#include "runtime/c/nodal_c_api.h"
#include "runtime/c/scene_c_api.h"

namespace tremolo::c_api {
namespace {

using Eigen::Vector3d;

// A model that calls added is named by its number after this, which begins no path.
constexpr char kGivenModel = '\0';

Result<tremolo_scene_body> complete_place(const tremolo_scene_body* place) {
  if (Status s = need({{place, "the body's place"}}); !s) return s.error();
  const auto full = complete(place, tremolo_scene_body_init, "tremolo_scene_body_init");
  if (!full) return full.error();
  if (full->name == nullptr || *full->name == '\0')
    return usage_error("a body of a scene needs a name");
  for (const auto& [what, values] :
       {std::pair{"position", full->position}, std::pair{"velocity", full->velocity},
        std::pair{"spin", full->spin}})
    if (!Vector3d(values).allFinite())
      return usage_error("body '" + std::string(full->name) + "': its " + what + " is not finite");
  if (const Status s = check_start_size(Vector3d(full->position), Vector3d(full->velocity),
                                        Vector3d(full->spin));
      !s)
    return usage_error("body '" + std::string(full->name) + "': " + s.error().message);
  return full;
}

ContactOptions contact_of(const tremolo_scene_body& place) {
  ContactOptions contact{.points = place.points,
                         .margin = place.margin,
                         .stiffness = place.stiffness,
                         .friction = place.friction,
                         .restitution = place.restitution};
  if (place.modulus != 0.0) contact.modulus = place.modulus;
  return contact;
}

// A reduced or rigid body without its model and its method.
Result<SceneBody> body_at(const tremolo_scene_body* given) {
  const Result<tremolo_scene_body> place = complete_place(given);
  if (!place) return place.error();
  SceneBody body;
  body.name = place->name;
  if (Status s = take(body.pose, to_pose(place->position, place->quaternion)); !s) return s.error();
  body.velocity = Vector3d(place->velocity);
  body.spin = Vector3d(place->spin);
  body.contact = contact_of(*place);
  return body;
}

Status set_method(const tremolo_body_options* given, SceneBody& body) {
  const Result<tremolo_body_options> full = complete_body_options(given);
  if (!full) return full.error();
  if (full->integrator != nullptr) body.integrator = full->integrator;
  if (Status s = take(body.options, to_integrator_options(*full)); !s) return s;
  return take(body.kind, to_frame(full->frame));
}

// Bodies of one model share it.
std::string number_of(const Model::Pointer& model, std::vector<Model::Pointer>& models) {
  const auto found = std::find(models.begin(), models.end(), model);
  const auto number = found - models.begin();
  if (found == models.end()) models.push_back(model);
  return kGivenModel + std::to_string(number);
}

Result<SignalKind> kind_of(std::int32_t signal) {
  switch (signal) {
    case TREMOLO_CONSTANT:
      return SignalKind::kConstant;
    case TREMOLO_PULSE:
      return SignalKind::kSquare;
    case TREMOLO_SINE:
      return SignalKind::kSine;
    case TREMOLO_RAMP:
      return SignalKind::kRamp;
    case TREMOLO_CHIRP:
      return SignalKind::kChirp;
    case TREMOLO_TABLE:
      return SignalKind::kTable;
    default:
      return usage_error("there is no signal " + std::to_string(signal));
  }
}

// kUsage for values that no signal of the kind has.
Status check_times(const Signal& signal) {
  const auto good = [](double value) { return std::isfinite(value) && value >= 0.0; };
  if (!good(signal.start) || !good(signal.duration))
    return usage_error("a load's start and duration must be finite and not negative");
  const bool waves = signal.kind == SignalKind::kSine || signal.kind == SignalKind::kChirp;
  if (waves && !(good(signal.frequency) && good(signal.last_frequency)))
    return usage_error("a load's frequencies must be finite and not negative");
  return Success{};
}

}  // namespace

Result<SceneBody> reduced_body(const tremolo_scene_body* place, const tremolo_model& model,
                               const tremolo_body_options* method, const tremolo_collider* shape,
                               std::vector<Model::Pointer>& models) {
  Result<SceneBody> body = body_at(place);
  if (!body) return body.error();
  if (Status s = set_method(method, *body); !s) return s.error();
  if (shape != nullptr) body->contact.shape = shape->shape;
  body->model = number_of(model.pointer, models);
  return body;
}

Result<SceneBody> rigid_body(const tremolo_scene_body* place, const tremolo_collider& shape,
                             double mass) {
  Result<SceneBody> body = body_at(place);
  if (!body) return body.error();
  body->kind = FrameKind::kFree;
  body->rigid.emplace();
  body->rigid->shape = shape.shape;
  body->rigid->mass = mass;
  return body;
}

Result<TetSceneBody> tets_body(const tremolo_scene_body* given,
                               const tremolo_tets_options* options) {
  const Result<tremolo_scene_body> place = complete_place(given);
  if (!place) return place.error();
  const auto full = complete(options, tremolo_tets_options_init, "tremolo_tets_options_init");
  if (!full) return full.error();
  if (Status s = need({{full->file, "the body's file"}}); !s) return s.error();
  TetSceneBody body;
  body.name = place->name;
  body.model = full->file;
  if (Status s = take(body.pose, to_pose(place->position, place->quaternion)); !s) return s.error();
  body.velocity = Vector3d(place->velocity);
  body.spin = Vector3d(place->spin);
  if (Status s = take(body.options, to_tets_options(*full)); !s) return s.error();
  body.contact = contact_of(*place);
  body.friction = body.contact.friction;
  return body;
}

Result<ClothSceneBody> cloth_body(const ClothScene& around, const tremolo_scene_body* given,
                                  const char* method, const tremolo_cloth_options* options,
                                  const size_t* pins, size_t count) {
  const Result<tremolo_scene_body> place = complete_place(given);
  if (!place) return place.error();
  const auto full = complete(options, tremolo_cloth_options_init, "tremolo_cloth_options_init");
  if (!full) return full.error();
  ClothSceneBody body;
  body.scene = around;
  if (method != nullptr) body.scene.integrator = method;
  SceneCloth cloth = to_cloth(*full, place->name);
  if (count > 0) {
    if (Status s = need({{pins, "the pins"}}); !s) return s.error();
    ClothPin pin;
    pin.particles.assign(pins, pins + count);
    cloth.pins.push_back(std::move(pin));
  }
  body.scene.cloths = {std::move(cloth)};
  body.velocity = Vector3d(place->velocity);
  const ContactOptions contact = contact_of(*place);
  body.contact.stiffness = contact.stiffness;
  body.contact.modulus = contact.modulus;
  return body;
}

Result<SceneCollider> scene_collider(const tremolo_placed_collider& collider, std::size_t number) {
  tremolo_placed_collider still = collider;
  std::copy_n(still.position, 3, still.next_position);
  std::copy_n(still.quaternion, 4, still.next_quaternion);
  std::vector<PlacedCollider> placed;
  if (Status s = place_colliders(&still, 1, placed); !s) return s.error();
  const PlacedCollider& one = placed.front();
  SceneCollider made;
  made.name = "collider " + std::to_string(number + 1);
  made.shape = one.shape;
  made.pose = one.start;
  made.friction = one.friction;
  made.restitution = one.restitution;
  return made;
}

Result<SceneJoint> scene_joint(const tremolo_joint& given) {
  const auto full = complete(&given, tremolo_joint_init, "tremolo_joint_init");
  if (!full) return full.error();
  if (Status s = need({{full->body, "the joint's body"}, {full->at, "the joint's place"}}); !s)
    return s.error();
  SceneJoint joint;
  joint.weld = full->weld != 0;
  joint.body = full->body;
  joint.at = full->at;
  if (full->to != nullptr) joint.to = full->to;
  if (full->to_at != nullptr) joint.to_at = full->to_at;
  if (full->point != nullptr) joint.point = Vector3d(full->point);
  if (joint.point && !joint.to.empty())
    return usage_error("a joint's point is of the world: `to` must be NULL");
  if (joint.point && !joint.point->allFinite())
    return usage_error("the joint of body '" + joint.body + "': its point is not finite");
  for (const double value : {full->stiffness, full->damping, full->length, full->gap})
    if (!(value >= 0.0) || !std::isfinite(value))
      return usage_error("a joint's values must be finite and not negative");
  for (const double value : {full->length, full->gap})
    if (overflows(value))
      return usage_error(
          overflow_text("the joint of body '" + joint.body + "': a length", value, "m"));
  if (joint.weld && full->length > 0.0) return usage_error("a weld has no length");
  if (full->stiffness > 0.0) joint.options.stiffness = full->stiffness;
  joint.options.damping = full->damping;
  joint.options.length = full->length;
  joint.options.touch = full->touch != 0;
  if (full->gap > 0.0) joint.gap = full->gap;
  joint.until = full->until;
  if (std::isnan(joint.until)) return usage_error("a joint's end is not a number");
  return joint;
}

Result<SceneLoad> scene_load(const tremolo_load& given) {
  const auto full = complete(&given, tremolo_load_init, "tremolo_load_init");
  if (!full) return full.error();
  SceneLoad load;
  if (Status s = take(load.signal.kind, kind_of(full->signal)); !s) return s.error();
  load.signal.start = full->start;
  load.signal.duration = full->duration;
  load.signal.frequency = full->frequency;
  load.signal.last_frequency = full->last_frequency;
  if (Status s = check_times(load.signal); !s) return s.error();
  if (load.signal.kind == SignalKind::kTable) {
    if (Status s = need({{full->times, "the load's times"}, {full->values, "the load's values"}});
        !s)
      return s.error();
    SignalTable table{{full->times, full->times + full->count},
                      {full->values, full->values + full->count}};
    if (const std::string problem = table_problem(table); !problem.empty())
      return usage_error("the load's table: " + problem);
    load.table = std::make_shared<const SignalTable>(std::move(table));
  }
  if (full->at != nullptr) load.at = full->at;
  load.force = Vector3d(full->force);
  load.scale = full->scale;
  if (!load.force.allFinite() || !std::isfinite(load.scale))
    return usage_error("a load's force must be finite");
  return load;
}

Result<Model::Pointer> model_of(const std::vector<Model::Pointer>& models, const SceneBody& body) {
  if (body.model.empty() || body.model.front() != kGivenModel) return load_scene_model(body);
  std::size_t number = 0;
  std::from_chars(body.model.data() + 1, body.model.data() + body.model.size(), number);
  return models[number];
}

}  // namespace tremolo::c_api

void tremolo_joint_init(tremolo_joint* joint) {
  if (joint == nullptr) return;
  *joint = {};
  joint->size = sizeof(tremolo_joint);
  joint->until = tremolo::kForEver;
}

void tremolo_load_init(tremolo_load* load) {
  if (load == nullptr) return;
  const tremolo::Signal usual;
  *load = {};
  load->size = sizeof(tremolo_load);
  load->scale = 1.0;
  load->frequency = usual.frequency;
  load->last_frequency = usual.last_frequency;
}
