#include "runtime/scene/scene_bones.h"

#include <algorithm>
#include <string>
#include <utility>

#include "common/number_text.h"

namespace tremolo {
namespace {

constexpr double kMostBoneLooks = 1e5;  // steps whose accelerations are looked at before a run

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

}  // namespace

Result<std::shared_ptr<const Skin>> make_scene_skin(const SceneBody& body, const Model& model) {
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
