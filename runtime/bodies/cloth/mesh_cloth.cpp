// A triangle mesh with springs along and across its edges.

#include <algorithm>
#include <array>
#include <numeric>
#include <string>

#include <Eigen/Geometry>

#include "common/union_find.h"
#include "formats/polygons/polygon_mesh.h"
#include "runtime/bodies/cloth/cloth_parts.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

// Ends of an edge, the smaller first, and the third corner of one of its triangles.
struct ClothEdge {
  VertexId a = 0, b = 0, opposite = 0;
  bool same_ends(const ClothEdge& other) const { return a == other.a && b == other.b; }
};

std::vector<ClothEdge> cloth_edges(const std::vector<Triangle>& triangles) {
  std::vector<ClothEdge> edges;
  edges.reserve(3 * triangles.size());
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(t[k], t[(k + 1) % 3]);
      edges.push_back({a, b, t[(k + 2) % 3]});
    }
  std::sort(edges.begin(), edges.end(), [](const ClothEdge& p, const ClothEdge& q) {
    return std::array{p.a, p.b, p.opposite} < std::array{q.a, q.b, q.opposite};
  });
  return edges;
}

NodePair cloth_pair(VertexId a, VertexId b) {
  return {static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b)};
}

// bent: the pairs across edges.
Status join_mesh(const std::vector<Triangle>& triangles, ClothSprings& edges_out,
                 std::vector<NodePair>& bent) {
  const std::vector<ClothEdge> edges = cloth_edges(triangles);
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end].same_ends(edges[i])) ++end;
    if (end - i > 2)
      return content_error("the edge of vertices " + std::to_string(edges[i].a) + " and " +
                           std::to_string(edges[i].b) + " has " + std::to_string(end - i) +
                           " triangles: a cloth's has one or two");
    edges_out.pairs.push_back(cloth_pair(edges[i].a, edges[i].b));
    if (end - i == 2) {
      if (edges[i].opposite == edges[i + 1].opposite)
        return content_error("two triangles have the same vertices, " + std::to_string(edges[i].a) +
                             ", " + std::to_string(edges[i].b) + " and " +
                             std::to_string(edges[i].opposite));
      const auto [a, b] = std::minmax(edges[i].opposite, edges[i + 1].opposite);
      bent.push_back(cloth_pair(a, b));
    }
    i = end;
  }
  return Success{};
}

Status weigh_mesh(const SurfaceMesh& mesh, double density, Eigen::VectorXd& mass) {
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    const auto at = [&](std::size_t k) { return mesh.vertices[t[k]]; };
    const double area = 0.5 * (at(1) - at(0)).cross(at(2) - at(0)).norm();
    if (!(area > 0.0)) return content_error("triangle " + std::to_string(i) + " has no area");
    for (const VertexId corner : t) mass[corner] += density * area / 3.0;
  }
  for (Eigen::Index i = 0; i < mass.size(); ++i)
    if (!(mass[i] > 0.0))
      return content_error("vertex " + std::to_string(i) + " is isolated: it has no triangle");
  return Success{};
}

}  // namespace

Result<ClothParts> make_mesh_cloth(const SceneCloth& cloth, const SurfaceMesh& mesh) {
  if (mesh.triangles.empty()) return content_error("the mesh has no triangle");
  ClothParts parts;
  parts.drag = cloth.drag;
  parts.triangles = mesh.triangles;
  const Eigen::Index n = mesh.vertices.size();
  parts.x.resize(3 * n);
  for (Eigen::Index i = 0; i < n; ++i) parts.x.segment<3>(3 * i) = cloth.placed(mesh.vertices[i]);
  if (!parts.x.allFinite()) return content_error("a vertex is not finite");
  parts.mass = Eigen::VectorXd::Zero(n);
  parts.structural.law = cloth.structural;
  parts.shear.law = cloth.shear;
  parts.bend.law = cloth.bend;
  if (Status s = join_mesh(mesh.triangles, parts.structural, parts.bend.pairs); !s)
    return s.error();
  parts.shear.pairs = parts.bend.pairs;
  if (Status s = measure_springs(parts.x, "structural", parts.structural); !s) return s.error();
  if (Status s = measure_springs(parts.x, "shear", parts.shear); !s) return s.error();
  if (Status s = measure_springs(parts.x, "bend", parts.bend); !s) return s.error();
  if (Status s = weigh_mesh(mesh, cloth.density, parts.mass); !s) return s.error();
  return parts;
}

Result<ClothParts> make_cloth_parts(const SceneCloth& cloth) {
  if (cloth.file.empty()) return make_grid_cloth(cloth);
  Result<PolygonMesh> polygons = read_polygons(cloth.file);
  if (!polygons) return polygons.error();
  const Result<SurfaceMesh> mesh = triangles_of(*polygons, cloth.file);
  if (!mesh) return mesh.error();
  const JoinedSeams joined = join_seams(*mesh);
  Result<ClothParts> parts = make_mesh_cloth(cloth, joined.mesh);
  if (!parts) return parts;
  std::vector<std::string> ignored;
  RenderSurface drawn = render_surface_of(std::move(*polygons), ignored);
  for (Vector3d& x : drawn.vertices) x = cloth.placed(x);
  for (Eigen::Vector3f& n : drawn.normals) n = cloth.rotation.cast<float>() * n;
  parts->drawn = std::make_shared<const RenderSurface>(std::move(drawn));
  parts->joined = mesh->vertices.size() - joined.mesh.vertices.size();
  if (parts->joined > 0) parts->particle_of = joined.particle_of;
  return parts;
}

std::size_t ClothParts::vertex_of_particle(std::size_t particle) const {
  if (particle_of.empty()) return particle;
  const auto found =
      std::find(particle_of.begin(), particle_of.end(), static_cast<VertexId>(particle));
  return static_cast<std::size_t>(found - particle_of.begin());
}

ClothLook look_of(const ClothParts& parts) {
  ClothLook look{parts.triangles, parts.uvs, {}};
  if (parts.drawn == nullptr || parts.drawn->uvs.empty()) {
    look.particles.resize(parts.particles());
    std::iota(look.particles.begin(), look.particles.end(), 0U);
    return look;
  }
  const RenderSurface& drawn = *parts.drawn;
  look.triangles = drawn.triangles;
  look.uvs = drawn.uvs;
  for (std::size_t v = 0; v < drawn.vertices.size(); ++v) {
    const std::size_t vertex =
        drawn.sources.empty() ? v : static_cast<std::size_t>(drawn.sources[v]);
    look.particles.push_back(static_cast<std::uint32_t>(parts.particle_of_vertex(vertex)));
  }
  return look;
}

RenderSurface drawn_at(const ClothParts& parts, const Eigen::VectorXd& x) {
  RenderSurface surface = *parts.drawn;
  for (std::size_t v = 0; v < surface.vertices.size(); ++v) {
    const std::size_t vertex =
        surface.sources.empty() ? v : static_cast<std::size_t>(surface.sources[v]);
    const auto particle = static_cast<Eigen::Index>(parts.particle_of_vertex(vertex));
    surface.vertices[v] = x.segment<3>(3 * particle);
  }
  return surface;
}

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
