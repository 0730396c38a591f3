#include "formats/surface/flat_rig.h"

#include <cmath>
#include <utility>

namespace tremolo {
namespace {

constexpr std::uint32_t kNoParentWord = 0xffffffff;

// Texts that each end with a zero byte; fewer than `count` if they do not.
std::vector<std::string> split_names(const std::string& text) {
  std::vector<std::string> names;
  for (std::size_t at = 0, end = 0; at < text.size(); at = end + 1) {
    end = text.find('\0', at);
    if (end == std::string::npos) return {};
    names.push_back(text.substr(at, end - at));
  }
  return names;
}

bool split_clips(const FlatRig& flat, std::size_t bones, SurfaceRig& rig) {
  const std::vector<std::string> names = split_names(flat.clip_names);
  if (names.size() != flat.clip_frames.size()) return false;
  std::size_t frame = 0;
  for (std::size_t c = 0; c < names.size(); ++c) {
    RigClip clip;
    clip.name = names[c];
    const std::size_t frames = flat.clip_frames[c];
    if (frames > flat.clip_times.size() - frame ||
        (frame + frames) * bones * 7 > flat.clip_poses.size())
      return false;
    for (std::size_t f = frame; f < frame + frames; ++f) {
      clip.times.push_back(flat.clip_times[f]);
      for (std::size_t b = 0; b < bones; ++b) {
        const double* pose = flat.clip_poses.data() + 7 * (f * bones + b);
        clip.poses.push_back({{pose[0], pose[1], pose[2]}, {pose[3], pose[4], pose[5], pose[6]}});
      }
    }
    frame += frames;
    rig.clips.push_back(std::move(clip));
  }
  return frame == flat.clip_times.size() && frame * bones * 7 == flat.clip_poses.size();
}

}  // namespace

FlatRig flatten(const SurfaceRig& rig) {
  FlatRig flat;
  for (const RigBone& bone : rig.bones) {
    flat.names.append(bone.name).push_back('\0');
    flat.parents.push_back(bone.parent < 0 ? kNoParentWord
                                           : static_cast<std::uint32_t>(bone.parent));
    flat.ends.insert(flat.ends.end(), bone.head.begin(), bone.head.end());
    flat.ends.insert(flat.ends.end(), bone.tail.begin(), bone.tail.end());
  }
  for (const RigWeight& weight : rig.weights) {
    flat.places.push_back(static_cast<std::uint32_t>(weight.vertex));
    flat.places.push_back(weight.bone);
    flat.weights.push_back(weight.weight);
  }
  for (const RigClip& clip : rig.clips) {
    flat.clip_names.append(clip.name).push_back('\0');
    flat.clip_frames.push_back(static_cast<std::uint32_t>(clip.times.size()));
    flat.clip_times.insert(flat.clip_times.end(), clip.times.begin(), clip.times.end());
    for (const RigPose& pose : clip.poses) {
      flat.clip_poses.insert(flat.clip_poses.end(), pose.position.begin(), pose.position.end());
      for (const double part :
           {pose.rotation.w(), pose.rotation.x(), pose.rotation.y(), pose.rotation.z()})
        flat.clip_poses.push_back(part);
    }
  }
  return flat;
}

std::shared_ptr<const SurfaceRig> unflatten(const FlatRig& flat, std::size_t vertices) {
  auto rig = std::make_shared<SurfaceRig>();
  std::vector<std::string> names = split_names(flat.names);
  const std::size_t bones = names.size();
  if (bones == 0 || flat.parents.size() != bones || flat.ends.size() != 6 * bones ||
      flat.places.size() != 2 * flat.weights.size())
    return nullptr;
  for (std::size_t b = 0; b < bones; ++b) {
    const double* ends = flat.ends.data() + 6 * b;
    const std::uint32_t parent = flat.parents[b];
    if (parent != kNoParentWord && parent >= b) return nullptr;
    rig->bones.push_back({std::move(names[b]),
                          parent == kNoParentWord ? kNoParent : static_cast<std::int32_t>(parent),
                          {ends[0], ends[1], ends[2]},
                          {ends[3], ends[4], ends[5]}});
  }
  for (std::size_t k = 0; k < flat.weights.size(); ++k)
    rig->weights.push_back(
        {static_cast<std::int32_t>(flat.places[2 * k]), flat.places[2 * k + 1], flat.weights[k]});
  if (!split_clips(flat, bones, *rig) || !rig_holds(*rig, vertices)) return nullptr;
  return rig;
}

}  // namespace tremolo
