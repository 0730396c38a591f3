// The skeleton of a scene that assimp has read.
#pragma once

#include <algorithm>
#include <assimp/types.h>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/render_surface.h"

namespace tremolo {

// Values of assimp as ours.
inline std::string_view text_of(const aiString& text) {
  return {text.data, std::min<std::size_t>(text.length, sizeof(text.data) - 1)};
}

inline Eigen::Matrix4d matrix_of(const aiMatrix4x4& m) {
  Eigen::Matrix4d matrix;
  matrix << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2,
      m.d3, m.d4;
  return matrix;
}

}  // namespace tremolo

struct aiAnimation;
struct aiMesh;
struct aiNode;
struct aiScene;

namespace tremolo {

// Bones are the nodes that skins refer to; the node tree gives their order and parents. Weights are
// added while the meshes are placed.
class SceneRig {
 public:
  // root: the transform above the scene's root node. A scene without skins has no bones.
  SceneRig(const aiScene& scene, const Eigen::Matrix4d& root);

  bool empty() const { return bones_.empty(); }
  // The node's transform in the world at rest, or null. Of two nodes with one name the first.
  const Eigen::Matrix4d* place_of(std::string_view node) const;
  // The bone that moves things attached to a node without a skin, or kNoParent.
  std::int32_t bone_of(const aiNode* node) const;

  // Weights of a skinned mesh's vertices; vertex_of: the surface's for each of the mesh's, or
  // negative.
  void add_skin(const aiMesh& mesh, const std::vector<std::int32_t>& vertex_of);

  // The rig with the recorded motions, for a surface of so many vertices; `carriers` has the bone
  // of vertices without a skin. Null without bones. Appends notes for the user.
  std::shared_ptr<const SurfaceRig> finish(const std::vector<std::int32_t>& carriers,
                                           std::vector<std::string>& notes);

 private:
  struct Node {
    const aiNode* node;
    std::int32_t parent, bone;  // among nodes_; its own bone or the one it is attached to
    Eigen::Matrix4d local, place;
  };
  RigClip read_clip(const aiAnimation& animation, double& stretch) const;

  const aiScene& scene_;
  Eigen::Matrix4d root_;
  std::vector<Node> nodes_;  // parents before children
  std::unordered_map<std::string_view, std::size_t> by_name_;
  std::unordered_map<const aiNode*, std::size_t> by_node_;
  std::vector<std::size_t> bones_;  // into nodes_
  std::vector<RigWeight> weights_;
};

}  // namespace tremolo
