#include "runtime/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "common/overflow.h"
#include "common/text.h"

namespace tremolo {
namespace {

Error error_of(const std::string& what, const Error& error) {
  return {error.kind, what + ": " + error.message};
}

Status check_gravity(const SceneGravity& gravity) {
  if (gravity.values.size() > 1 && gravity.times.size() != gravity.values.size())
    return content_error("gravity: each value needs a time");
  for (std::size_t k = 0; k < gravity.values.size(); ++k) {
    if (!gravity.values[k].allFinite()) return content_error("gravity is not finite");
    if (Status s = check_size("gravity", gravity.values[k].lpNorm<Eigen::Infinity>(), "m/s^2"); !s)
      return s;
    if (gravity.values.size() == 1) break;
    if (!std::isfinite(gravity.times[k])) return content_error("gravity: a time is not finite");
    if (k > 0 && !(gravity.times[k - 1] < gravity.times[k]))
      return content_error("gravity: the times must ascend");
  }
  return Success{};
}

Status check_motion(const SceneBody& body) {
  if (body.motion.parts.empty()) return Success{};
  if (body.kind != FrameKind::kDriven)
    return content_error("a motion moves a driven body only: say kind = \"driven\"");
  const Result<MotionPath> path = MotionPath::create(body.motion, body.pose);
  return path ? Status(Success{}) : Status(path.error());
}

Status check_contact(const ContactOptions& contact) {
  if (contact.points < 1) return content_error("contact-points must be at least 1");
  if (!(contact.margin > 0.0 && contact.margin < 1.0))
    return content_error("contact-margin must be above 0 and below 1 (a share of the size)");
  if (!(contact.stiffness > 0.0) || !std::isfinite(contact.stiffness))
    return content_error("contact-stiffness must be positive and finite");
  if (Status s = check_size("contact-stiffness", contact.stiffness, ""); !s) return s;
  if (contact.modulus)
    if (Status s = check_size("contact-modulus", *contact.modulus, "Pa"); !s) return s;
  if (!(contact.friction >= 0.0) || !std::isfinite(contact.friction))
    return content_error("friction is " + number_text(contact.friction) +
                         ", must be finite and not negative");
  if (!(contact.restitution >= 0.0 && contact.restitution <= 1.0))
    return content_error("restitution is " + number_text(contact.restitution) +
                         ", must be from 0 to 1");
  if (contact.shape)
    if (Status s = check(*contact.shape); !s) return content_error("shape: " + s.error().message);
  return Success{};
}

Status check_loads(const SceneBody& body) {
  for (const SceneLoad& load : body.loads) {
    if (!load.force.allFinite() || !std::isfinite(load.scale))
      return content_error("a load's force or scale is not finite");
    if (Status s = check_signal_size(load.signal); !s) return s;
    if (load.signal.kind != SignalKind::kTable) continue;
    const std::string problem =
        load.table ? table_problem(*load.table) : std::string("it has no table");
    if (!problem.empty()) return content_error("a load's signal: " + problem);
  }
  return Success{};
}

Status check_damping(const SceneBody& body) {
  const std::vector<double>& by_mode = body.options.ratios.of_modes;
  if (Status s = check_ratios(body.options.ratios, std::max<std::size_t>(by_mode.size(), 1)); !s)
    return s;
  for (const auto& [key, course] :
       {std::pair{"alpha", &body.alphas}, std::pair{"beta", &body.betas}}) {
    double before = -1.0;
    for (const ValueFrom& from : *course) {
      if (!(from.time >= 0.0) || !std::isfinite(from.time) || !(from.time > before))
        return content_error(std::string(key) + ": its moments must not be negative, and ascend");
      if (!(from.value >= 0.0) || !std::isfinite(from.value))
        return content_error(std::string(key) + " must be finite and not negative");
      if (Status s = check_size(key, from.value, ""); !s) return s;
      before = from.time;
    }
  }
  return Success{};
}

Status check_bones(const SceneBody& body) {
  if (body.rig && (!body.bones.empty() || body.bone_weights.size() > 0))
    return content_error(
        "rig: bones and weights are those of the model: leave [[bodies.bones]] and "
        "bone-weights out");
  if (!body.rig && !body.clip.empty())
    return content_error("clip: it is a motion of the model's bones: say rig = true");
  if (body.rig && body.kind != FrameKind::kDriven)
    return content_error("rig: bones carry a driven body only: say kind = \"driven\"");
  if (body.bones.empty()) {
    if (body.bone_weights.size() > 0) return content_error("bone-weights: it has no bones");
    return Success{};
  }
  if (body.kind != FrameKind::kDriven)
    return content_error("bones carry a driven body only: say kind = \"driven\"");
  if (!(body.bone_blend >= 0.0) || !std::isfinite(body.bone_blend))
    return content_error("bone-blend must be finite and not negative (m)");
  std::set<std::string> names;
  for (const SceneBone& bone : body.bones) {
    if (bone.name.empty()) return content_error("a bone has no name");
    const std::string what = "bone '" + bone.name + "': ";
    if (!bone.parent.empty() && !names.contains(bone.parent))
      return content_error(what + "parent: there is no bone '" + bone.parent + "' before it");
    if (!names.insert(bone.name).second)
      return content_error("two bones are named '" + bone.name + "'");
    if (!bone.head.allFinite() || !bone.tail.allFinite())
      return content_error(what + "its head or tail is not finite");
    if (const Result<MotionPath> path = MotionPath::create(bone.motion); !path)
      return content_error(what + path.error().message);
  }
  if (body.bone_weights.size() == 0) return Success{};
  if (body.bone_weights.cols() != std::ssize(body.bones))
    return content_error("bone-weights: there are " + std::to_string(body.bone_weights.cols()) +
                         " columns for " + std::to_string(body.bones.size()) + " bones");
  const std::string problem = weights_problem(body.bone_weights);
  return problem.empty() ? Status(Success{}) : content_error("bone-weights: " + problem);
}

// A rigid body has no coordinates: what belongs to them is refused.
Status check_rigid(const SceneBody& body) {
  if (!body.model.empty())
    return content_error("model: a rigid body is made of its shape or mesh: leave the model out");
  if (body.kind != FrameKind::kFree)
    return content_error("a rigid body is free: pins hold it, and a collider follows a motion");
  if (body.rigid->shape && (body.contact.shape || !body.shape_file.empty()))
    return content_error("shape: the solid of a rigid body is also the shape of its contact");
  const IntegratorOptions& options = body.options;
  if (options.alpha != 0.0 || options.beta != 0.0 || options.ratios.of_each_mode() ||
      !body.alphas.empty() || !body.betas.empty())
    return content_error(
        "alpha, beta and damping-ratio damp what is relative to the frame: a rigid body has no "
        "such motion");
  const std::string& method = body.integrator;
  if (method != "avf" && method != "ep2" && method != "ep4")
    return content_error("integrator: a rigid body goes with avf, ep2 and ep4, not with '" +
                         method + "'");
  for (const SceneLoad& load : body.loads)
    if (load.at.empty() && load.signal.kind != SignalKind::kNone)
      return content_error("load: a rigid body has no load of its own: say `at` and `force`");
  return check(*body.rigid);
}

Status check_body(const SceneBody& body) {
  if (body.rigid)
    if (Status s = check_rigid(body); !s) return s;
  if (!body.rigid && body.model.empty())
    return content_error("its model is empty: give the path of a basis file");
  if (const std::string problem = pose_problem(body.pose); !problem.empty())
    return content_error(problem);
  if (!body.velocity.allFinite() || !body.spin.allFinite())
    return content_error("its velocity or spin is not finite");
  if (Status s = check_start_size(body.pose.position, body.velocity, body.spin); !s) return s;
  const bool free = body.kind == FrameKind::kFree;
  if (!free && !(body.velocity.isZero(0.0) && body.spin.isZero(0.0)))
    return content_error("velocity and spin are those of a free body: say kind = \"free\"");
  if (free && body.settled)
    return content_error("a free body falls: it cannot begin standing still under gravity");
  if (!(body.acceleration_limit > 0.0))
    return content_error("its acceleration-limit must be positive (m/s^2)");
  if (Status s = check_loads(body); !s) return s;
  if (Status s = check_damping(body); !s) return s;
  if (Status s = check_contact(body.contact); !s) return s;
  if (Status s = check_bones(body); !s) return s;
  return check_motion(body);
}

// Checks the method of a body that needs contact.
Status check_method(const SceneBody& body) {
  const std::string& method = body.integrator;
  if (frame_kind(body) == FrameKind::kFixed || method == "avf" || method == "ep2" ||
      method == "ep4")
    return Success{};
  return content_error("integrator: what touches or holds a body that is not fixed at the origin " +
                       ("goes with avf, ep2 and ep4, not with '" + method + "'") +
                       "; with contact = false it touches nothing, and no hand may hold it");
}

Status check_collider(const SceneCollider& collider) {
  if (collider.file.empty())
    if (Status s = check(collider.shape); !s) return s;
  if (const std::string problem = pose_problem(collider.pose); !problem.empty())
    return content_error(problem);
  if (Status s = check_size("its position", collider.pose.position.lpNorm<Eigen::Infinity>(), "m");
      !s)
    return s;
  if (!(collider.friction >= 0.0) || !std::isfinite(collider.friction))
    return content_error("friction is " + number_text(collider.friction) +
                         ", must be finite and not negative");
  if (!(collider.restitution >= 0.0 && collider.restitution <= 1.0))
    return content_error("restitution is " + number_text(collider.restitution) +
                         ", must be from 0 to 1");
  const Result<MotionPath> path = MotionPath::create(collider.motion, collider.pose);
  return path ? Status(Success{}) : Status(path.error());
}

Status check_colliders(const Scene& scene) {
  std::set<std::string> names;
  for (const SceneCollider& collider : scene.colliders) {
    if (collider.name.empty()) return content_error("a collider has no name");
    if (!names.insert(collider.name).second)
      return content_error("two colliders are named '" + collider.name + "'");
    if (Status s = check_collider(collider); !s)
      return error_of("collider '" + collider.name + "'", s.error());
  }
  return Success{};
}

// bodies: names of those that there are.
Status check_hand(const SceneHand& hand, const std::set<std::string>& bodies) {
  if (!bodies.contains(hand.body))
    return content_error("body: there is no body '" + hand.body + "'");
  if (hand.at.empty()) return content_error("at: it is empty: give a vertex");
  if (!hand.pin && (!(hand.stiffness > 0.0) || !std::isfinite(hand.stiffness)))
    return content_error("stiffness must be positive and finite (N/m)");
  if (!(hand.damping >= 0.0) || !std::isfinite(hand.damping))
    return content_error("damping must be finite and not negative (N s/m)");
  if (hand.position && !hand.position->allFinite()) return content_error("position is not finite");
  // A stiffer spring than that of a pin is limited to that.
  if (hand.position)
    if (Status s = check_size("position", hand.position->lpNorm<Eigen::Infinity>(), "m"); !s)
      return s;
  if (!(hand.from >= 0.0) || !std::isfinite(hand.from))
    return content_error("from must be finite and not negative (s)");
  if (!(hand.until > hand.from)) return content_error("until must be behind from (s)");
  const Result<MotionPath> path = MotionPath::create(hand.motion);
  if (!path) return path.error();
  if (path->refused_jump() < kForEver)
    return content_error("its motion jumps at t = " + number_text(path->refused_jump()) +
                         " s: say jumps = \"smooth\" to spread it over smooth-time, or "
                         "\"teleport\"");
  return Success{};
}

// Of a joint, to the world or not.
Status check_world_end(const SceneJoint& joint) {
  if (!joint.to.empty())
    return joint.point ? Status(content_error("point: only a joint to the world has one"))
                       : Status(Success{});
  if (!joint.to_at.empty()) return content_error("to-at: the world has no vertices: say `point`");
  if (joint.gap) return content_error("gap: a weld to the world has none");
  if (joint.weld && joint.point)
    return content_error("point: a weld to the world holds its vertices where they are");
  if (joint.point && !joint.point->allFinite()) return content_error("point is not finite");
  if (!joint.point && joint.options.length != 0.0)
    return content_error("a joint to the world with a length needs a `point`");
  return Success{};
}

}  // namespace

Status check_joint(const SceneJoint& joint, const std::set<std::string>& bodies) {
  const bool to_world = joint.to.empty();
  for (const auto& [key, name] : {std::pair{"body", &joint.body}, std::pair{"to", &joint.to}})
    if (!bodies.contains(*name) && !(to_world && name == &joint.to))
      return content_error(std::string(key) + ": there is no body '" + *name + "'");
  if (joint.body == joint.to) return content_error("to: it joins '" + joint.to + "' to itself");
  if (joint.at.empty()) return content_error("at: it is empty: give a vertex");
  const JointOptions& options = joint.options;
  if (options.stiffness && (!(*options.stiffness > 0.0) || !std::isfinite(*options.stiffness)))
    return content_error("stiffness must be positive and finite (N/m)");
  if (!(options.damping >= 0.0) || !std::isfinite(options.damping))
    return content_error("damping must be finite and not negative (N s/m)");
  if (!(options.length >= 0.0) || !std::isfinite(options.length))
    return content_error("length must be finite and not negative (m)");
  for (const auto& [name, value] :
       {std::pair{"length", options.length},
        {"gap", joint.gap.value_or(0.0)},
        {"point", joint.point ? joint.point->lpNorm<Eigen::Infinity>() : 0.0}})
    if (Status s = check_size(name, value, "m"); !s) return s;
  if (Status s = check_world_end(joint); !s) return s;
  if (joint.weld && options.length != 0.0) return content_error("a weld has no length");
  if (joint.gap && !joint.weld) return content_error("gap: only a weld has one");
  if (joint.gap && (!(*joint.gap >= 0.0) || !std::isfinite(*joint.gap)))
    return content_error("gap must be finite and not negative (m)");
  if (!(joint.until > 0.0)) return content_error("until must be positive (s)");
  return Success{};
}

FrameKind frame_kind(const SceneBody& body) {
  const bool at_origin = body.pose.position.isZero(0.0) && body.pose.rotation.vec().isZero(0.0);
  if (body.kind == FrameKind::kFixed && !at_origin) return FrameKind::kDriven;
  return body.kind;
}

bool bodies_touch(const Scene& scene) {
  const auto feels = [](const SceneBody& body) { return body.feels_contact; };
  return std::count_if(scene.bodies.begin(), scene.bodies.end(), feels) > 1 &&
         std::any_of(scene.bodies.begin(), scene.bodies.end(),
                     [](const SceneBody& body) { return body.feels_contact && has_shape(body); });
}

bool needs_contact(const Scene& scene, const SceneBody& body) {
  return ContactNeeds(scene).of(body);
}

ContactNeeds::ContactNeeds(const Scene& scene)
    : felt_(!scene.colliders.empty() || bodies_touch(scene)) {
  for (const SceneHand& hand : scene.hands) held_.insert(hand.body);
  for (const SceneJoint& joint : scene.joints) held_.insert({joint.body, joint.to});
}

bool ContactNeeds::of(const SceneBody& body) const {
  return (body.feels_contact && felt_) || held_.contains(body.name);
}

Eigen::Vector3d SceneGravity::at(double t) const {
  if (values.empty()) return Eigen::Vector3d::Zero();
  if (values.size() == 1 || t <= times.front()) return values.front();
  if (t >= times.back()) return values.back();
  const auto next = std::upper_bound(times.begin(), times.end(), t);
  const auto k = static_cast<std::size_t>(next - times.begin()) - 1;
  const double share = (t - times[k]) / (times[k + 1] - times[k]);
  return values[k] + share * (values[k + 1] - values[k]);
}

Status check_scene(const Scene& scene) {
  if (!(scene.step > 0.0) || !std::isfinite(scene.step))
    return content_error("step must be positive and finite (s)");
  if (Status s = check_step_size(scene.step); !s) return s;
  if (!(scene.duration > 0.0) || !std::isfinite(scene.duration))
    return content_error("duration must be positive and finite (s)");
  if (scene.duration / scene.step > 1e12)
    return content_error("duration and step ask for more than 1e12 steps");
  if (scene.duration < 0.5 * scene.step)
    return content_error("duration is shorter than half a step: nothing would be done");
  if (scene.bodies.empty() && scene.guests.empty()) return content_error("the scene has no body");
  if (Status s = check_gravity(scene.gravity); !s) return s;
  std::set<std::string> names;
  const ContactNeeds needs(scene);
  for (const SceneBody& body : scene.bodies) {
    if (body.name.empty()) return content_error("a body has no name");
    if (!names.insert(body.name).second)
      return content_error("two bodies are named '" + body.name + "'");
    Status good = check_body(body);
    if (good && needs.of(body)) good = check_method(body);
    if (!good) return error_of("body '" + body.name + "'", good.error());
  }
  if (Status s = check_colliders(scene); !s) return s;
  names.insert(scene.guests.begin(), scene.guests.end());
  for (std::size_t i = 0; i < scene.hands.size(); ++i)
    if (Status s = check_hand(scene.hands[i], names); !s)
      return error_of_listed("hand", i, scene.hands[i], s.error());
  for (std::size_t i = 0; i < scene.joints.size(); ++i)
    if (Status s = check_joint(scene.joints[i], names); !s)
      return error_of_listed("joint", i, scene.joints[i], s.error());
  return Success{};
}

}  // namespace tremolo
