// The bones of a scene's body as functions of time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/result.h"
#include "runtime/bodies/reduced/frames/driven_frame.h"
#include "runtime/bones.h"
#include "runtime/math/motion.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// For a body with `rig`, fills in the bones of its model's render surface: heads, weights, and the
// clip as keyframes, a bone's relative to its parent. Errors (kContent): a surface without a rig, a
// clip that does not exist.
Status take_rig(SceneBody& body, const Model& model);

// The skin of the body's bones. Errors of skin_of_weights and skin_near_bones.
Result<std::shared_ptr<const Skin>> make_scene_skin(const SceneBody& body, const Model& model);

// T_b(t) = T_parent(t) (h_b M_b(t) h_b^-1): M_b is the bone's own motion, about its head, where
// h_b puts the origin; the parent of a bone that names none is the body's frame.
class BonePaths {
 public:
  // Errors: kContent, with the bone's name, for a motion that is not valid or that jumps.
  static Result<BonePaths> create(const SceneBody& body);

  std::size_t size() const { return bones_.size(); }
  // Writes one pose per bone. Allocates nothing.
  void poses(double t, std::span<Pose> out) const;
  // The motion of every bone in the k-th step, counted from 0, and where it ends. Nothing is
  // allocated. Valid until the next call.
  struct Step {
    std::span<const Pose> before, start, end, after;
    FrameMotion motion(std::size_t bone, double step) const {
      return motion_between(before[bone], start[bone], end[bone], after[bone], step);
    }
  };
  Step step(std::int64_t k, double step);

 private:
  struct Bone {
    MotionPath path;  // of M_b h_b^-1
    Eigen::Vector3d head;
    std::size_t parent;  // size(): the body's frame
  };

  explicit BonePaths(MotionPath root) : root_(std::move(root)) {}

  MotionPath root_;
  std::vector<Bone> bones_;
  std::vector<Pose> poses_[4];
};

// Errors: kContent, telling the bone and the acceleration, where a point within `reach` (m) of the
// mesh's origin would be accelerated by a bone above the body's limit.
Status check_bone_accelerations(const SceneBody& wanted, BonePaths& paths, const Scene& scene,
                                double reach);

}  // namespace tremolo
