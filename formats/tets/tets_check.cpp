#include <cmath>

#include "common/mesh/render_surface.h"
#include "formats/tets/tets_layout.h"

namespace tremolo {
namespace {

template <class Index>
bool all_below(const Index& indices, std::size_t count) {
  for (const auto i : indices)
    if (i < 0 || static_cast<std::size_t>(i) >= count) return false;
  return true;
}

std::optional<TetsFault> mesh_fault(const TetMesh& mesh) {
  if (mesh.tetrahedra.empty()) return TetsFault{tets_layout::kTetrahedra, "there are none"};
  for (const Eigen::Vector3d& x : mesh.vertices)
    if (!x.allFinite()) return TetsFault{tets_layout::kVertices, "a value is not finite"};
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) {
    const std::string name = "tetrahedron " + std::to_string(e);
    if (!all_below(mesh.tetrahedra[e], mesh.vertices.size()))
      return TetsFault{tets_layout::kTetrahedra, name + " has a vertex that is not there"};
    if (!(signed_volume(mesh, mesh.tetrahedra[e]) > 0.0))
      return TetsFault{tets_layout::kTetrahedra, name + " has no volume above zero"};
  }
  return std::nullopt;
}

std::optional<TetsFault> material_fault(const TetMesh& mesh, const MaterialTable& materials) {
  if (materials.materials.empty()) return TetsFault{tets_layout::kMaterials, "there are none"};
  for (const NamedMaterial& named : materials.materials)
    if (const Status status = check_material(named.material); !status)
      return TetsFault{tets_layout::kMaterials, status.error().message};
  if (materials.of_tet.size() != mesh.tetrahedra.size() && !materials.of_tet.empty())
    return TetsFault{tets_layout::kMaterialOf, "it is not one a tetrahedron"};
  if (!all_below(materials.of_tet, materials.materials.size()))
    return TetsFault{tets_layout::kMaterialOf, "a material is not there"};
  return std::nullopt;
}

std::optional<TetsFault> surface_fault(const TetMesh& mesh, const TetsSurface& surface) {
  const std::size_t count = surface.vertices.size();
  if (surface.tetrahedra.size() != count || surface.weights.size() != count ||
      (!surface.uvs.empty() && surface.uvs.size() != count))
    return TetsFault{tets_layout::kDrawnVertices, "lists of different lengths"};
  for (const Triangle& triangle : surface.triangles)
    if (!all_below(triangle, count))
      return TetsFault{tets_layout::kDrawnTriangles, "a vertex is not there"};
  for (std::size_t v = 0; v < count; ++v) {
    const std::string name = "vertex " + std::to_string(v);
    if (!surface.vertices[v].allFinite())
      return TetsFault{tets_layout::kDrawnVertices, name + " is not finite"};
    if (surface.tetrahedra[v] >= mesh.tetrahedra.size())
      return TetsFault{tets_layout::kDrawnTetrahedra, name + " hangs on none"};
    // The weights of vertices outside the mesh are in [-2, 3] (precompute/embedding/).
    const Eigen::Vector4d& w = surface.weights[v];
    if (!(w.cwiseAbs().maxCoeff() < 16.0) || !(std::abs(w.sum() - 1.0) < 1e-6))
      return TetsFault{tets_layout::kDrawnWeights,
                       "the weights of " + name + " are too large or their sum is not 1"};
  }
  for (const Eigen::Vector2f& uv : surface.uvs)
    if (!uv.allFinite()) return TetsFault{tets_layout::kDrawnUvs, "a value is not finite"};
  if (surface.sources.empty()) return std::nullopt;
  RenderSurface drawn;
  drawn.vertices = surface.vertices;
  drawn.sources = surface.sources;
  if (!drawn.sources_hold())
    return TetsFault{tets_layout::kDrawnSources,
                     "the vertices of the author's file do not come first, each as itself"};
  return std::nullopt;
}

}  // namespace

std::optional<TetsFault> find_tets_fault(const TetMesh& mesh, const MaterialTable& materials,
                                         std::span<const VertexId> held,
                                         const TetsSurface& surface) {
  if (auto fault = mesh_fault(mesh)) return fault;
  if (auto fault = material_fault(mesh, materials)) return fault;
  for (std::size_t i = 0; i < held.size(); ++i)
    if (held[i] < 0 || static_cast<std::size_t>(held[i]) >= mesh.vertices.size() ||
        (i > 0 && held[i] <= held[i - 1]))
      return TetsFault{tets_layout::kHeld, "not ascending, or a vertex that is not there"};
  return surface_fault(mesh, surface);
}

}  // namespace tremolo
