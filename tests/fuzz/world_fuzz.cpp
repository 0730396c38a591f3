// Scenes with [[bodies]]: whatever is read is a scene that check_scene() lets pass.
#include <array>

#include "runtime/integrator.h"
#include "runtime/io/scenes/scene_reader.h"
#include "tests/fuzz/harness.h"

// The methods themselves would take minutes to build.
std::span<const std::string_view> tremolo::integrator_names() {
  static constexpr std::array<std::string_view, 2> kNames = {"ep4", "imexv"};
  return kNames;
}

void tremolo::fuzz::read_input(std::string_view bytes) {
  const Result<SceneFile> file = parse_world(bytes, "folder/input.toml");
  check_error(file);
  if (!file) return;
  if (file->scene.bodies.empty()) finding("a scene without a body");
  for (const SceneBody& body : file->scene.bodies) {
    if (body.name.empty() || body.model.empty() || body.name.find('/') != std::string::npos)
      finding("a body without a name or a model");
    const Result<MotionPath> path = MotionPath::create(body.motion, body.pose);
    if (!path) finding("an invalid motion");
    for (const double t : {-1.0, 0.0, 0.5, 1e3})
      if (!pose_problem(path->pose(t)).empty()) finding("an invalid pose");
    for (const SceneBone& bone : body.bones)
      if (bone.name.empty() || !MotionPath::create(bone.motion)) finding("an invalid bone");
    if (!(body.contact.margin > 0.0) || body.contact.points < 1)
      finding("contact without a margin or a point");
  }
  for (const SceneCollider& collider : file->scene.colliders) {
    if (collider.file.empty() && !check(collider.shape)) finding("an invalid shape");
    if (!(collider.friction >= 0.0) || !(collider.restitution <= 1.0))
      finding("friction or restitution out of range");
    if (!MotionPath::create(collider.motion, collider.pose)) finding("an invalid motion");
  }
  for (const SceneHand& hand : file->scene.hands)
    if (!(hand.pin || hand.stiffness > 0.0) || !(hand.until > hand.from))
      finding("a hand that holds nothing");
  for (const SceneJoint& joint : file->scene.joints)
    if (joint.body == joint.to || joint.at.empty() ||
        !(joint.options.stiffness.value_or(1.0) > 0.0))
      finding("a joint that joins nothing");
}
