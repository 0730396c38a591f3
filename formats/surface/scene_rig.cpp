#include "formats/surface/scene_rig.h"

#include <algorithm>
#include <assimp/scene.h>
#include <cmath>
#include <limits>
#include <unordered_set>
#include <utility>

#include <Eigen/Dense>

#include "common/text.h"
#include "formats/file/printable_text.h"
#include "formats/surface/surface_answer.h"

namespace tremolo {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kMostPoses = 4e6;    // of a clip: frames times nodes
constexpr double kUsualTicks = 25.0;  // a second, where a file does not say

// The value at a time between keys, straight lines between; mix(a, b, share).
template <class Key, class Mix>
auto value_at(const Key* keys, unsigned count, double time, const Mix& mix) {
  const Key* end = keys + count;
  const Key* next =
      std::upper_bound(keys, end, time, [](double t, const Key& key) { return t < key.mTime; });
  if (next == keys) return mix(keys[0].mValue, keys[0].mValue, 0.0);
  if (next == end) return mix(end[-1].mValue, end[-1].mValue, 0.0);
  const double gap = next->mTime - next[-1].mTime;
  return mix(next[-1].mValue, next->mValue, gap > 0 ? (time - next[-1].mTime) / gap : 0.0);
}

Vector3d mix_vectors(const aiVector3D& a, const aiVector3D& b, double share) {
  return (1.0 - share) * Vector3d(a.x, a.y, a.z) + share * Vector3d(b.x, b.y, b.z);
}

Quaterniond mix_turns(const aiQuaternion& a, const aiQuaternion& b, double share) {
  return Quaterniond(a.w, a.x, a.y, a.z)
      .normalized()
      .slerp(share, Quaterniond(b.w, b.x, b.y, b.z).normalized());
}

// A node's own transform at a time, in ticks.
Matrix4d local_at(const aiNodeAnim& channel, double time) {
  Eigen::Affine3d local = Eigen::Affine3d::Identity();
  if (channel.mNumPositionKeys > 0)
    local.translate(value_at(channel.mPositionKeys, channel.mNumPositionKeys, time, mix_vectors));
  if (channel.mNumRotationKeys > 0)
    local.rotate(value_at(channel.mRotationKeys, channel.mNumRotationKeys, time, mix_turns));
  if (channel.mNumScalingKeys > 0)
    local.scale(value_at(channel.mScalingKeys, channel.mNumScalingKeys, time, mix_vectors));
  return local.matrix();
}

// The nearest rigid motion that takes the head where the map does. stretch: how far the map is from
// rigid, of one.
RigPose rigid_part(const Matrix4d& map, const Vector3d& head, double& stretch) {
  const Eigen::JacobiSVD<Matrix3d> svd(map.topLeftCorner<3, 3>(),
                                       Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d turn = svd.matrixU() * svd.matrixV().transpose();
  if (turn.determinant() < 0) {
    Matrix3d u = svd.matrixU();
    u.col(2) = -u.col(2);
    turn = u * svd.matrixV().transpose();
  }
  stretch = std::max(stretch, (svd.singularValues().array() - 1.0).abs().maxCoeff());
  const Vector3d there = map.topLeftCorner<3, 3>() * head + map.topRightCorner<3, 1>();
  return {there - turn * head, Quaterniond(turn).normalized()};
}

std::unordered_set<std::string_view> names_of_bones(const aiScene& scene) {
  std::unordered_set<std::string_view> names;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m)
    for (unsigned b = 0; b < scene.mMeshes[m]->mNumBones; ++b)
      names.insert(text_of(scene.mMeshes[m]->mBones[b]->mName));
  return names;
}

}  // namespace

SceneRig::SceneRig(const aiScene& scene, const Matrix4d& root) : scene_(scene), root_(root) {
  std::unordered_set<std::string_view> names = names_of_bones(scene);
  if (names.empty()) return;
  std::vector<std::pair<const aiNode*, std::int32_t>> stack = {{scene.mRootNode, kNoParent}};
  while (!stack.empty()) {
    const auto [node, parent] = stack.back();
    stack.pop_back();
    const Matrix4d local = matrix_of(node->mTransformation);
    const Matrix4d place =
        (parent < 0 ? root_ : nodes_[static_cast<std::size_t>(parent)].place) * local;
    const auto number = static_cast<std::int32_t>(nodes_.size());
    std::int32_t bone = parent < 0 ? kNoParent : nodes_[static_cast<std::size_t>(parent)].bone;
    if (names.erase(text_of(node->mName)) > 0) {
      bone = static_cast<std::int32_t>(bones_.size());
      bones_.push_back(nodes_.size());
    }
    by_name_.try_emplace(text_of(node->mName), nodes_.size());
    by_node_.try_emplace(node, nodes_.size());
    nodes_.push_back({node, parent, bone, local, place});
    for (unsigned child = node->mNumChildren; child-- > 0;)
      stack.emplace_back(node->mChildren[child], number);
  }
}

const Matrix4d* SceneRig::place_of(std::string_view node) const {
  const auto found = by_name_.find(node);
  return found == by_name_.end() ? nullptr : &nodes_[found->second].place;
}

std::int32_t SceneRig::bone_of(const aiNode* node) const {
  const auto found = by_node_.find(node);
  return found == by_node_.end() ? kNoParent : nodes_[found->second].bone;
}

void SceneRig::add_skin(const aiMesh& mesh, const std::vector<std::int32_t>& vertex_of) {
  for (unsigned b = 0; b < mesh.mNumBones; ++b) {
    const aiBone& bone = *mesh.mBones[b];
    const auto node = by_name_.find(text_of(bone.mName));
    if (node == by_name_.end() || nodes_[node->second].bone < 0) continue;
    for (unsigned k = 0; k < bone.mNumWeights; ++k) {
      const aiVertexWeight& weight = bone.mWeights[k];
      if (weight.mVertexId >= vertex_of.size() || vertex_of[weight.mVertexId] < 0 ||
          !(weight.mWeight > 0) || !std::isfinite(weight.mWeight))
        continue;
      weights_.push_back({vertex_of[weight.mVertexId],
                          static_cast<std::uint32_t>(nodes_[node->second].bone), weight.mWeight});
    }
  }
}

RigClip SceneRig::read_clip(const aiAnimation& animation, double& stretch) const {
  RigClip clip;
  clip.name = printable_text(text_of(animation.mName), kLongestName);
  std::unordered_map<std::string_view, const aiNodeAnim*> channels;
  std::vector<double> ticks;
  for (unsigned c = 0; c < animation.mNumChannels; ++c) {
    const aiNodeAnim& channel = *animation.mChannels[c];
    if (!by_name_.contains(text_of(channel.mNodeName))) continue;
    channels.try_emplace(text_of(channel.mNodeName), &channel);
    const auto add = [&ticks](const auto* keys, unsigned count) {
      for (unsigned k = 0; k < count; ++k)
        if (std::isfinite(keys[k].mTime)) ticks.push_back(keys[k].mTime);
    };
    add(channel.mPositionKeys, channel.mNumPositionKeys);
    add(channel.mRotationKeys, channel.mNumRotationKeys);
    add(channel.mScalingKeys, channel.mNumScalingKeys);
  }
  std::sort(ticks.begin(), ticks.end());
  const double second = animation.mTicksPerSecond > 0 ? animation.mTicksPerSecond : kUsualTicks;
  // Times that differ only by a float's rounding are equal.
  const auto same = [second](double a, double b) { return b - a < 1e-6 * second; };
  ticks.erase(std::unique(ticks.begin(), ticks.end(), same), ticks.end());
  if (static_cast<double>(ticks.size()) * static_cast<double>(nodes_.size()) > kMostPoses)
    return clip;
  std::vector<const aiNodeAnim*> of_node;
  for (const Node& node : nodes_) {
    const auto found = channels.find(text_of(node.node->mName));
    of_node.push_back(found == channels.end() ? nullptr : found->second);
  }
  std::vector<Matrix4d> places(nodes_.size());
  for (const double tick : ticks) {
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      const Matrix4d local = of_node[n] != nullptr ? local_at(*of_node[n], tick) : nodes_[n].local;
      places[n] =
          (nodes_[n].parent < 0 ? root_ : places[static_cast<std::size_t>(nodes_[n].parent)]) *
          local;
    }
    clip.times.push_back(tick / second);
    for (const std::size_t n : bones_)
      clip.poses.push_back(rigid_part(places[n] * nodes_[n].place.inverse(),
                                      nodes_[n].place.topRightCorner<3, 1>(), stretch));
  }
  return clip;
}

std::shared_ptr<const SurfaceRig> SceneRig::finish(const std::vector<std::int32_t>& carriers,
                                                   std::vector<std::string>& notes) {
  if (empty()) return nullptr;
  auto rig = std::make_shared<SurfaceRig>();
  UniqueNames names("bone");
  for (const std::size_t n : bones_) {
    RigBone bone;
    bone.name = names.take(text_of(nodes_[n].node->mName));
    const std::int32_t above = nodes_[n].parent;
    if (above >= 0) bone.parent = nodes_[static_cast<std::size_t>(above)].bone;
    bone.head = bone.tail = nodes_[n].place.topRightCorner<3, 1>();
    rig->bones.push_back(std::move(bone));
  }
  for (std::size_t b = rig->bones.size(); b-- > 0;)
    if (rig->bones[b].parent >= 0)
      rig->bones[static_cast<std::size_t>(rig->bones[b].parent)].tail = rig->bones[b].head;
  double stretch = 0.0;
  for (unsigned a = 0; a < scene_.mNumAnimations; ++a) {
    RigClip clip = read_clip(*scene_.mAnimations[a], stretch);
    const bool good = !clip.times.empty() &&
                      std::all_of(clip.poses.begin(), clip.poses.end(), [](const RigPose& pose) {
                        return pose.position.allFinite() && pose.rotation.coeffs().allFinite();
                      });
    if (good)
      rig->clips.push_back(std::move(clip));
    else
      notes.push_back("movement '" + clip.name + "' left out: it moves no bone, or is too long");
  }
  if (stretch > 1e-3)
    notes.push_back("movements scale their bones by up to " + number_text(100 * stretch) +
                    " %: left out, bones move rigidly");
  // Each vertex once, with weights that sum to one; a vertex without weights follows a bone that
  // does not move.
  std::sort(weights_.begin(), weights_.end(), [](const RigWeight& a, const RigWeight& b) {
    return std::pair(a.vertex, a.bone) < std::pair(b.vertex, b.bone);
  });
  std::int32_t still = kNoParent;
  std::size_t at = 0;
  for (std::size_t v = 0; v < carriers.size(); ++v) {
    const std::size_t begin = rig->weights.size();
    float sum = 0.0F;
    for (; at < weights_.size() && std::cmp_equal(weights_[at].vertex, v); ++at) {
      sum += weights_[at].weight;
      if (rig->weights.size() > begin && rig->weights.back().bone == weights_[at].bone)
        rig->weights.back().weight += weights_[at].weight;
      else
        rig->weights.push_back(weights_[at]);
    }
    if (sum > 0.0F) {
      for (std::size_t k = begin; k < rig->weights.size(); ++k) rig->weights[k].weight /= sum;
      continue;
    }
    std::int32_t bone = carriers[v];
    if (bone < 0) {
      if (still < 0) {
        still = static_cast<std::int32_t>(rig->bones.size());
        rig->bones.push_back({names.take("not on bones"), kNoParent, {0, 0, 0}, {0, 0, 0}});
      }
      bone = still;
    }
    rig->weights.push_back({static_cast<std::int32_t>(v), static_cast<std::uint32_t>(bone), 1.0F});
  }
  if (still >= 0) {
    const std::size_t bones = rig->bones.size();
    for (RigClip& clip : rig->clips) {
      std::vector<RigPose> poses;
      for (std::size_t f = 0; f < clip.times.size(); ++f) {
        const auto first = clip.poses.begin() + static_cast<std::ptrdiff_t>(f * (bones - 1));
        poses.insert(poses.end(), first, first + static_cast<std::ptrdiff_t>(bones - 1));
        poses.emplace_back();
      }
      clip.poses = std::move(poses);
    }
  }
  return rig;
}

}  // namespace tremolo
