// A scene's meshes, each where its nodes put it, as one surface.
#pragma once

#include <algorithm>
#include <assimp/types.h>
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "common/mesh/render_surface.h"

struct aiMesh;
struct aiScene;

namespace tremolo {

// Why a scene cannot become a surface.
struct Refusal {
  std::string message;
};

inline std::string_view text_of(const aiString& text) {
  return {text.data, std::min<std::size_t>(text.length, sizeof(text.data) - 1)};
}

// Names as they are asked for, each made printable and different from those before; `nameless`
// where there is none.
class UniqueNames {
 public:
  explicit UniqueNames(std::string nameless) : nameless_(std::move(nameless)) {}

  std::string take(std::string_view wanted);

 private:
  std::string nameless_;
  std::unordered_set<std::string> taken_;
  std::unordered_map<std::string, std::uint64_t> repeats_;
};

// Takes triangles alone; counts what it leaves out. bytes: what the surface may take. Its functions
// may throw Refusal.
class Flattener {
 public:
  Flattener(const aiScene& scene, std::uint64_t bytes) : scene_(scene), bytes_(bytes) {}

  // All nodes, divided by what of the file's unit is in the root's transform.
  void add_nodes(double file_scale);
  void fill_normals();
  void note_what_was_left_out(std::vector<std::string>& notes) const;

  RenderSurface surface;

 private:
  struct Placement;
  void add_mesh(const aiMesh& mesh, const Placement& place);
  VertexId vertex_of(const aiMesh& mesh, unsigned index, const Placement& place);
  std::uint32_t material_of(unsigned index);

  const aiScene& scene_;
  std::uint64_t bytes_;
  std::vector<VertexId> taken_;  // of the mesh at hand: the surface's vertices of the mesh's
  std::vector<bool> has_normal_;
  bool any_normal_ = false;
  bool any_uv_ = false;
  bool any_colour_ = false;
  UniqueNames object_names_{"object"};
  UniqueNames material_names_{"material"};
  std::unordered_map<unsigned, std::uint32_t> materials_;
  std::uint64_t points_ = 0;
  std::uint64_t lines_ = 0;
  std::uint64_t polygons_ = 0;
  std::uint64_t not_finite_ = 0;
  std::uint64_t skinned_ = 0;
};

}  // namespace tremolo
