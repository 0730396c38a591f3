#include "runtime/cloth/cloth_seams.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "common/mesh/union_find.h"

namespace tremolo {
namespace {

constexpr double kSeamWidth = 1e-6;  // of the mesh's size: the last digits of an exporter

// Vertices of edges that have one triangle, ascending.
std::vector<VertexId> border_of(const SurfaceMesh& mesh) {
  std::vector<std::array<VertexId, 2>> edges;
  for (const Triangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(t[k], t[(k + 1) % 3]);
      edges.push_back({a, b});
    }
  std::sort(edges.begin(), edges.end());
  std::vector<VertexId> border;
  for (std::size_t i = 0, end = 0; i < edges.size(); i = end) {
    for (end = i + 1; end < edges.size() && edges[end] == edges[i];) ++end;
    if (end == i + 1) border.insert(border.end(), edges[i].begin(), edges[i].end());
  }
  std::sort(border.begin(), border.end());
  border.erase(std::unique(border.begin(), border.end()), border.end());
  return border;
}

}  // namespace

JoinedSeams join_seams(const SurfaceMesh& mesh) {
  const double width = kSeamWidth * bounding_box(mesh.vertices).diagonal();
  std::vector<VertexId> border = border_of(mesh);
  const auto& at = mesh.vertices;
  std::stable_sort(border.begin(), border.end(),
                   [&at](VertexId a, VertexId b) { return at[a].x() < at[b].x(); });
  std::vector<VertexId> groups(mesh.vertices.size());
  std::iota(groups.begin(), groups.end(), 0);
  for (std::size_t i = 0; i < border.size(); ++i)
    for (std::size_t k = i + 1; k < border.size() && at[border[k]].x() - at[border[i]].x() <= width;
         ++k)
      if ((at[border[k]] - at[border[i]]).norm() <= width) join_sets(groups, border[i], border[k]);
  JoinedSeams joined;
  joined.particle_of.assign(mesh.vertices.size(), -1);
  std::vector<VertexId> of_group(mesh.vertices.size(), -1);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    VertexId& particle = of_group[root_of(groups, static_cast<VertexId>(v))];
    if (particle < 0) {
      particle = static_cast<VertexId>(joined.mesh.vertices.size());
      joined.mesh.vertices.push_back(mesh.vertices[v]);
    }
    joined.particle_of[v] = particle;
  }
  for (const Triangle& t : mesh.triangles)
    joined.mesh.triangles.push_back(
        {joined.particle_of[t[0]], joined.particle_of[t[1]], joined.particle_of[t[2]]});
  return joined;
}

}  // namespace tremolo
