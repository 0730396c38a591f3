#include <span>
#include <string>
#include <utility>

#include "runtime/world/identity.h"
#include "runtime/world/scene_world.h"

namespace tremolo {
namespace {

void add(Identity& identity, const Course& course) {
  identity.add(course.start, course.end, course.ramp);
}

struct PartAdder {
  Identity& identity;

  void operator()(const ShakeMotion& part) const {
    identity.add(part.amplitude, part.frequency);
    add(identity, part.course);
  }
  void operator()(const SpinMotion& part) const {
    identity.add(part.axis, part.about, part.rate);
    add(identity, part.course);
  }
  void operator()(const SwingMotion& part) const {
    identity.add(part.axis, part.about, part.amplitude, part.frequency, part.phase);
    add(identity, part.course);
  }
  void operator()(const GlideMotion& part) const {
    identity.add(part.velocity);
    add(identity, part.course);
  }
  void operator()(const FallMotion& part) const {
    identity.add(part.acceleration);
    add(identity, part.course);
  }
  void operator()(const KeyframeMotion& part) const {
    identity.add(part.interpolation, part.jumps, part.smooth_time, part.keys.size());
    if (part.absolute) identity.add(part.absolute);
    for (const Keyframe& key : part.keys) identity.add(key.time, key.pose);
  }
  void operator()(const RecordMotion& part) const { identity.add(part.times, part.accelerations); }
};

struct ShapeAdder {
  Identity& identity;

  void operator()(const PlaneShape&) const {}
  void operator()(const SphereShape& shape) const { identity.add(shape.radius); }
  void operator()(const CapsuleShape& shape) const {
    identity.add(shape.radius, shape.half_length);
  }
  void operator()(const BoxShape& shape) const { identity.add(shape.half_extents); }
  void operator()(const CylinderShape& shape) const {
    identity.add(shape.radius, shape.half_length);
  }
  void operator()(const GridShape& shape) const { identity.add(shape.grid->content_hash()); }
};

void add(Identity& identity, const Collider& shape) {
  identity.add(shape.index());
  std::visit(ShapeAdder{identity}, shape);
}

void add(Identity& identity, const SceneLoad& load) {
  identity.add(load.signal.kind, load.signal.start, load.signal.duration, load.signal.frequency);
  if (load.signal.kind == SignalKind::kChirp) identity.add(load.signal.last_frequency);
  if (load.table) identity.add(load.table->times, load.table->values);
  identity.add(load.at, load.force, load.scale);
}

std::uint64_t hash_of(const SceneBody& body, const Model& model, const Collider* shape) {
  Identity identity;
  const IntegratorOptions& options = body.options;
  identity.add(model.content_hash(), body.kind, body.integrator, options.alpha, options.beta);
  identity.add(options.newmark_beta, options.newmark_gamma, options.split.rule);
  identity.add(options.split.count, options.split.safety, options.tolerance);
  identity.add(options.max_iterations, options.halvings, body.pose, body.velocity, body.spin);
  identity.add(body.settled, body.loads.size());
  if (options.ratios.of_each_mode()) {
    identity.add(options.ratios.of_modes, options.ratios.table.size());
    for (const RatioAt& row : options.ratios.table) identity.add(row.frequency, row.ratio);
  }
  for (const std::vector<ValueFrom>* course : {&body.alphas, &body.betas}) {
    if (!course->empty()) identity.add(course->size());
    for (const ValueFrom& from : *course) identity.add(from.time, from.value);
  }
  for (const SceneLoad& load : body.loads) add(identity, load);
  add(identity, body.motion);
  const BoneWeights& weights = body.bone_weights;
  identity.add(body.bones.size(), body.bone_blend,
               std::vector<double>(weights.data(), weights.data() + weights.size()));
  for (const SceneBone& bone : body.bones) {
    identity.add(bone.name, bone.parent, bone.head, bone.tail);
    add(identity, bone.motion);
  }
  const ContactOptions& contact = body.contact;
  identity.add(body.feels_contact, contact.points, contact.margin, contact.stiffness);
  identity.add(contact.friction, contact.restitution, shape != nullptr);
  if (shape != nullptr) add(identity, *shape);
  return identity.hash();
}

std::uint64_t hash_of(const SceneCollider& collider, const PlacedCollider& placed) {
  Identity identity;
  add(identity, placed.shape);
  identity.add(collider.pose, collider.friction, collider.restitution);
  add(identity, collider.motion);
  return identity.hash();
}

std::uint64_t hash_of(const SceneHand& hand) {
  Identity identity;
  identity.add(hand.body, hand.at, hand.stiffness, hand.damping, hand.position, hand.from);
  identity.add(hand.until, hand.pin);
  add(identity, hand.motion);
  return identity.hash();
}

std::uint64_t hash_of(const SceneJoint& joint) {
  Identity identity;
  const JointOptions& options = joint.options;
  identity.add(joint.body, joint.at, joint.to, joint.to_at, joint.until, options.touch);
  identity.add(options.stiffness.value_or(0.0), options.damping, options.length);
  if (joint.weld) identity.add(joint.weld, joint.gap);
  if (joint.point) identity.add(joint.point);
  return identity.hash();
}

}  // namespace

void add(Identity& identity, const Motion& motion) {
  identity.add(motion.parts.size());
  for (const MotionPart& part : motion.parts) {
    identity.add(part.index());
    std::visit(PartAdder{identity}, part);
  }
}

std::uint64_t with_load(std::uint64_t body, const SceneLoad& load) {
  Identity identity;
  identity.add(body);
  add(identity, load);
  return identity.hash();
}

std::vector<SavedPart> scene_parts(const Scene& scene, const std::vector<const Model*>& models,
                                   const std::vector<const Collider*>& shapes,
                                   std::span<const PlacedCollider> colliders) {
  std::vector<SavedPart> parts;
  Identity whole;
  parts.push_back(
      {"step or gravity", whole.add(scene.step, scene.gravity.times, scene.gravity.values).hash()});
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    parts.push_back(
        {"body '" + scene.bodies[i].name + "'", hash_of(scene.bodies[i], *models[i], shapes[i])});
  for (std::size_t c = 0; c < scene.colliders.size(); ++c)
    parts.push_back(
        {"collider '" + scene.colliders[c].name + "'", hash_of(scene.colliders[c], colliders[c])});
  for (std::size_t k = 0; k < scene.hands.size(); ++k)
    parts.push_back({"hand " + std::to_string(k + 1), hash_of(scene.hands[k])});
  for (std::size_t k = 0; k < scene.joints.size(); ++k)
    parts.push_back({"joint " + std::to_string(k + 1), hash_of(scene.joints[k])});
  return parts;
}

}  // namespace tremolo
