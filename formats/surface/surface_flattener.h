// A scene's meshes, each where its nodes put it, as one surface.
#pragma once

#include <algorithm>
#include <assimp/types.h>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/render_surface.h"
#include "formats/file/printable_text.h"
#include "formats/polygons/polygon_mesh.h"
#include "formats/surface/scene_rig.h"

struct aiMesh;
struct aiScene;

namespace tremolo {

// Why a scene cannot become a surface.
struct Refusal {
  std::string message;
};

// Collects triangles; counts other things, which are left out. bytes: limit for the surface. Its
// functions may throw Refusal.
class Flattener {
 public:
  Flattener(const aiScene& scene, std::uint64_t bytes) : scene_(scene), bytes_(bytes) {}

  // Adds all nodes, divided by the part of the file's unit that is in the root's transform. The
  // position of a skinned mesh follows from its joints and their inverse bind matrices at rest; its
  // own node is ignored.
  void add_nodes(double file_scale);
  void fill_normals();
  // Gives the surface its skeleton; false if the scene has none.
  bool take_rig(std::vector<std::string>& notes);
  void note_what_was_left_out(std::vector<std::string>& notes) const;

  RenderSurface surface;

 private:
  struct Placement;
  void add_mesh(const aiMesh& mesh, const Placement& place);
  VertexId vertex_of(const aiMesh& mesh, unsigned index, const Placement& place);
  void find_skin(const aiMesh& mesh);
  std::uint32_t material_of(unsigned index);

  const aiScene& scene_;
  std::uint64_t bytes_;
  std::optional<SceneRig> rig_;
  std::vector<std::int32_t> carriers_;  // of each vertex: the bone that its node is attached to
  std::vector<Eigen::Matrix<double, 4, 5>> skin_;  // of the mesh at hand: blended matrix, weights
  std::vector<VertexId> taken_;  // of the mesh at hand: the surface's vertices of the mesh's
  std::vector<bool> has_normal_;
  bool any_uv_ = false;
  bool any_colour_ = false;
  UniqueNames object_names_{"object"};
  UniqueNames material_names_{"material"};
  std::unordered_map<unsigned, std::uint32_t> materials_;
  LeftOut left_out_;
  std::uint64_t morphed_ = 0;
};

}  // namespace tremolo
