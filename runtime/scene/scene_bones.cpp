#include "runtime/scene/scene_bones.h"

#include <algorithm>
#include <string>
#include <utility>

#include "common/text.h"

namespace tremolo {
namespace {

constexpr double kMostBoneLooks = 1e5;  // steps whose accelerations are checked before a run

Error error_of_bone(const SceneBone& bone, const std::string& problem) {
  return content_error("bone '" + bone.name + "': " + problem);
}

Status check_steady(const MotionPath& path) {
  if (path.jumps().empty()) return Success{};
  return content_error("its motion jumps at t = " + number_text(path.jumps().front()) +
                       " s: say jumps = \"smooth\" to spread it over smooth-time");
}

Pose after(const Pose& first, const Pose& then) {
  return {first * then.position, (first.rotation * then.rotation).normalized()};
}

Result<std::shared_ptr<const Skin>> skin_without_names(const SceneBody& body, const Model& model) {
  if (body.bone_weights.size() > 0) {
    Result<std::shared_ptr<const Skin>> skin = skin_of_weights(model, body.bone_weights);
    if (!skin) return Error{skin.error().kind, "bone-weights: " + skin.error().message};
    return skin;
  }
  std::vector<BoneSegment> segments;
  for (const SceneBone& bone : body.bones) segments.push_back({bone.head, bone.tail});
  return skin_near_bones(model, segments,
                         body.bone_blend > 0.0 ? body.bone_blend : usual_blend(model));
}

// clip: the one of that name, the first one for an empty name, null for a rig without any.
Status find_clip(const SurfaceRig& rig, const std::string& name, const RigClip*& clip) {
  if (name.empty()) {
    if (!rig.clips.empty()) clip = &rig.clips.front();
    return Success{};
  }
  std::string names;
  for (const RigClip& each : rig.clips) {
    if (each.name == name) clip = &each;
    names += (names.empty() ? "'" : ", '") + each.name + "'";
  }
  if (clip != nullptr) return Success{};
  return content_error("clip: there is no '" + name + "'; the render surface has " +
                       (names.empty() ? "none" : names));
}

// M = h^-1 T_parent^-1 T h of each frame: the bone's own motion about its head.
Motion bone_motion(const SurfaceRig& rig, const RigClip& clip, std::size_t bone) {
  const std::int32_t parent = rig.bones[bone].parent;
  const Eigen::Vector3d& head = rig.bones[bone].head;
  KeyframeMotion keys;
  for (std::size_t f = 0; f < clip.times.size(); ++f) {
    const RigPose* frame = clip.poses.data() + f * rig.bones.size();
    Eigen::Quaterniond turn = frame[bone].rotation;
    Eigen::Vector3d there = turn * head + frame[bone].position;
    if (parent >= 0) {
      const RigPose& above = frame[parent];
      turn = above.rotation.conjugate() * turn;
      there = above.rotation.conjugate() * (there - above.position);
    }
    if (!keys.keys.empty() && keys.keys.back().pose.rotation.dot(turn) < 0.0)
      turn.coeffs() = -turn.coeffs();
    keys.keys.push_back({clip.times[f], {there - head, turn.normalized()}});
  }
  const bool still = std::all_of(keys.keys.begin(), keys.keys.end(), [](const Keyframe& key) {
    return key.pose.position.norm() < 1e-12 && key.pose.rotation.vec().norm() < 1e-12;
  });
  return still ? Motion{} : Motion{{keys}};
}

}  // namespace

Status take_rig(SceneBody& body, const Model& model) {
  const RenderBlock* render = model.render();
  if (render == nullptr || render->surface.rig == nullptr)
    return content_error(
        "rig: the model's render surface has no bones: make it from a skinned .glb, .gltf or .fbx");
  const SurfaceRig& rig = *render->surface.rig;
  const RigClip* clip = nullptr;
  if (Status s = find_clip(rig, body.clip, clip); !s) return s;
  body.bones.clear();
  for (std::size_t b = 0; b < rig.bones.size(); ++b) {
    const RigBone& from = rig.bones[b];
    SceneBone bone;
    bone.name = from.name;
    bone.head = from.head;
    bone.tail = from.tail;
    if (from.parent >= 0) bone.parent = rig.bones[static_cast<std::size_t>(from.parent)].name;
    if (clip != nullptr) bone.motion = bone_motion(rig, *clip, b);
    body.bones.push_back(std::move(bone));
  }
  body.bone_weights =
      BoneWeights::Zero(std::ssize(render->surface.vertices), std::ssize(rig.bones));
  for (const RigWeight& weight : rig.weights)
    body.bone_weights(weight.vertex, weight.bone) = weight.weight;
  return Success{};
}

Result<std::shared_ptr<const Skin>> make_scene_skin(const SceneBody& body, const Model& model) {
  Result<std::shared_ptr<const Skin>> skin = skin_without_names(body, model);
  if (!skin) return skin;
  Skin named = **skin;
  for (const SceneBone& bone : body.bones) named.names.push_back(bone.name);
  return std::make_shared<const Skin>(std::move(named));
}

Result<BonePaths> BonePaths::create(const SceneBody& body) {
  Result<MotionPath> root =
      MotionPath::create(body.motion, {body.pose.position, body.pose.rotation.normalized()});
  if (!root) return root.error();
  if (Status s = check_steady(*root); !s) return s.error();
  BonePaths paths(std::move(*root));
  for (const SceneBone& bone : body.bones) {
    Result<MotionPath> path =
        MotionPath::create(bone.motion, {-bone.head, Eigen::Quaterniond::Identity()});
    if (!path) return error_of_bone(bone, path.error().message);
    if (Status s = check_steady(*path); !s) return error_of_bone(bone, s.error().message);
    const auto named = [&bone](const SceneBone& other) { return other.name == bone.parent; };
    const std::size_t parent =
        std::find_if(body.bones.begin(), body.bones.end(), named) - body.bones.begin();
    paths.bones_.push_back({std::move(*path), bone.head, parent});
  }
  for (std::vector<Pose>& poses : paths.poses_) poses.resize(paths.size());
  return paths;
}

void BonePaths::poses(double t, std::span<Pose> out) const {
  const Pose root = root_.pose(t);
  for (std::size_t b = 0; b < size(); ++b) {
    const Bone& bone = bones_[b];
    Pose own = bone.path.pose(t);
    own.position += bone.head;
    out[b] = after(bone.parent < b ? out[bone.parent] : root, own);
  }
}

BonePaths::Step BonePaths::step(std::int64_t k, double step) {
  for (int i = 0; i < 4; ++i) poses(static_cast<double>(k - 1 + i) * step, poses_[i]);
  return {poses_[0], poses_[1], poses_[2], poses_[3]};
}

Status check_bone_accelerations(const SceneBody& wanted, BonePaths& paths, const Scene& scene,
                                double reach) {
  const double looks = std::min(scene.duration / scene.step, kMostBoneLooks);
  for (std::int64_t k = 0; static_cast<double>(k) < looks; ++k) {
    const BonePaths::Step step = paths.step(k, scene.step);
    for (std::size_t b = 0; b < paths.size(); ++b) {
      const FrameMotion motion = step.motion(b, scene.step);
      const double most = motion.acceleration.norm() +
                          reach * (motion.spin_rate.norm() + motion.spin.squaredNorm());
      if (most > wanted.acceleration_limit)
        return error_of_bone(
            wanted.bones[b],
            "its motion accelerates it at t = " + number_text(static_cast<double>(k) * scene.step) +
                " s by up to " + number_text(most) +
                " m/s^2, above the body's acceleration-limit of " +
                number_text(wanted.acceleration_limit) + " m/s^2");
    }
  }
  return Success{};
}

}  // namespace tremolo
