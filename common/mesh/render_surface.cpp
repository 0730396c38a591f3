#include "common/mesh/render_surface.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace tremolo {
namespace {

constexpr double kWeightsSlack = 1e-3;  // of the sum of a vertex's weights: floats of a file

bool bones_hold(const std::vector<RigBone>& bones) {
  std::set<std::string> names;
  for (std::size_t b = 0; b < bones.size(); ++b) {
    const RigBone& bone = bones[b];
    if (bone.name.empty() || !names.insert(bone.name).second) return false;
    if (bone.parent < kNoParent || bone.parent >= static_cast<std::int64_t>(b)) return false;
    if (!bone.head.allFinite() || !bone.tail.allFinite()) return false;
  }
  return !bones.empty();
}

bool clip_holds(const RigClip& clip, std::size_t bones) {
  if (clip.times.empty() || clip.poses.size() != clip.times.size() * bones) return false;
  for (std::size_t k = 0; k < clip.times.size(); ++k)
    if (!std::isfinite(clip.times[k]) || (k > 0 && !(clip.times[k] > clip.times[k - 1])))
      return false;
  return std::all_of(clip.poses.begin(), clip.poses.end(), [](const RigPose& pose) {
    return pose.position.allFinite() && std::abs(pose.rotation.norm() - 1.0) < 1e-6;
  });
}

}  // namespace

bool rig_holds(const SurfaceRig& rig, std::size_t vertices) {
  if (!bones_hold(rig.bones)) return false;
  std::vector<double> sums(vertices, 0.0);
  for (std::size_t k = 0; k < rig.weights.size(); ++k) {
    const RigWeight& weight = rig.weights[k];
    if (weight.vertex < 0 || static_cast<std::size_t>(weight.vertex) >= vertices ||
        weight.bone >= rig.bones.size() || !(weight.weight >= 0.0F) || !(weight.weight <= 1.001F))
      return false;
    if (k > 0 &&
        (weight.vertex < rig.weights[k - 1].vertex ||
         (weight.vertex == rig.weights[k - 1].vertex && weight.bone <= rig.weights[k - 1].bone)))
      return false;
    sums[static_cast<std::size_t>(weight.vertex)] += weight.weight;
  }
  return std::all_of(sums.begin(), sums.end(),
                     [](double sum) { return std::abs(sum - 1.0) < kWeightsSlack; }) &&
         std::all_of(rig.clips.begin(), rig.clips.end(),
                     [&](const RigClip& clip) { return clip_holds(clip, rig.bones.size()); });
}

}  // namespace tremolo
