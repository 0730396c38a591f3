#include "common/mesh/edge_points.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

namespace tremolo {
namespace {

using Ends = std::pair<VertexId, VertexId>;

Ends ends_of(const Tetrahedron& tet, std::size_t edge) {
  return std::minmax({tet[kTetEdges[edge][0]], tet[kTetEdges[edge][1]]});
}

// Calls visit(tetrahedron, edge of it, which of `edges`); `edges` are ascending by their ends.
template <class Edge, class Key, class Visit>
void for_each_tet_edge(const TetMesh& mesh, const std::vector<Edge>& edges, const Key& key,
                       const Visit& visit) {
  // Edges with the same lower end are adjacent: a short list to search.
  std::vector<std::size_t> start(mesh.vertices.size() + 1, 0);
  for (const Edge& edge : edges) ++start[key(edge).first + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
    for (std::size_t e = 0; e < 6; ++e) {
      const Ends ends = ends_of(mesh.tetrahedra[t], e);
      const auto first = edges.begin() + start[ends.first];
      const auto last = edges.begin() + start[ends.first + 1];
      const auto found = std::lower_bound(
          first, last, ends, [&](const Edge& edge, const Ends& x) { return key(edge) < x; });
      const bool there = found != last && key(*found) == ends;
      visit(t, e, there ? found - edges.begin() : std::ptrdiff_t{-1});
    }
}

std::string name_of(const MeshEdge& edge) {
  return "the edge between vertices " + std::to_string(edge.a) + " and " + std::to_string(edge.b);
}

// Takes the points of the tetrahedra from `edges`. Returns the first edge that has none.
std::string find_points(TetMesh& mesh) {
  std::vector<MeshEdge> by_ends = mesh.edges;
  const auto key = [](const MeshEdge& edge) { return Ends{edge.a, edge.b}; };
  std::sort(by_ends.begin(), by_ends.end(),
            [&](const MeshEdge& x, const MeshEdge& y) { return key(x) < key(y); });
  std::string missing;
  mesh.edge_points.assign(mesh.tetrahedra.size(), TetEdges{});
  for_each_tet_edge(mesh, by_ends, key, [&](std::size_t t, std::size_t e, std::ptrdiff_t at) {
    if (at >= 0) {
      mesh.edge_points[t][e] = by_ends[at].point;
    } else if (missing.empty()) {
      const auto [a, b] = ends_of(mesh.tetrahedra[t], e);
      missing = name_of({-1, a, b}) + " of tetrahedron " + std::to_string(t);
    }
  });
  return missing;
}

Status check_file_edges(const TetMesh& mesh) {
  std::vector<char> corner(mesh.vertices.size(), 0);
  for (const Tetrahedron& tet : mesh.tetrahedra)
    for (const VertexId v : tet) corner[v] = 1;
  const MeshEdge* last = nullptr;
  for (const MeshEdge& edge : mesh.edges) {
    if (corner[edge.point] != 0)
      return content_error("vertex " + std::to_string(edge.point) + " is the middle of " +
                           name_of(edge) + " and a corner of a tetrahedron as well");
    if (last != nullptr && last->point == edge.point)
      return content_error("vertex " + std::to_string(edge.point) +
                           " is the middle of two edges: " + name_of(*last) + " and " +
                           name_of(edge));
    last = &edge;
  }
  std::vector<MeshEdge> by_ends = mesh.edges;
  const auto same = [](const MeshEdge& x, const MeshEdge& y) { return x.a == y.a && x.b == y.b; };
  std::stable_sort(by_ends.begin(), by_ends.end(), [](const MeshEdge& x, const MeshEdge& y) {
    return Ends{x.a, x.b} < Ends{y.a, y.b};
  });
  const auto twice = std::adjacent_find(by_ends.begin(), by_ends.end(), same);
  if (twice != by_ends.end())
    return content_error(name_of(*twice) + " has two points, " + std::to_string(twice->point) +
                         " and " + std::to_string(std::next(twice)->point) +
                         ": tetrahedra that share an edge must share its point");
  return Success{};
}

}  // namespace

std::vector<std::pair<VertexId, VertexId>> mesh_edges(const TetMesh& mesh) {
  std::vector<std::size_t> start(mesh.vertices.size() + 1, 0);
  for (const Tetrahedron& tet : mesh.tetrahedra)
    for (std::size_t e = 0; e < 6; ++e) ++start[ends_of(tet, e).first + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<VertexId> others(start.back());
  std::vector<std::size_t> end(start.begin(), start.end() - 1);
  for (const Tetrahedron& tet : mesh.tetrahedra)
    for (std::size_t e = 0; e < 6; ++e) {
      const auto [a, b] = ends_of(tet, e);
      others[end[a]++] = b;
    }
  std::vector<Ends> edges;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const auto first = others.begin() + start[v], last = others.begin() + end[v];
    std::sort(first, last);
    const auto stop = std::unique(first, last);
    for (auto at = first; at != stop; ++at) edges.emplace_back(static_cast<VertexId>(v), *at);
  }
  return edges;
}

Status add_edge_points(TetMesh& mesh) {
  if (!mesh.edges.empty()) {
    const std::string missing = find_points(mesh);
    if (!missing.empty()) return content_error(missing + " has no point");
    return Success{};
  }
  const std::vector<Ends> edges = mesh_edges(mesh);
  if (!std::in_range<VertexId>(mesh.vertices.size() + edges.size()))
    return content_error("with a point on each edge the mesh has 2^31 vertices or more");
  mesh.vertices.reserve(mesh.vertices.size() + edges.size());
  mesh.edges.reserve(edges.size());
  for (const auto& [a, b] : edges) {
    mesh.edges.push_back({static_cast<VertexId>(mesh.vertices.size()), a, b});
    const Eigen::Vector3d middle = 0.5 * (mesh.vertices[a] + mesh.vertices[b]);
    mesh.vertices.push_back(middle);
  }
  if (!mesh.colours.empty()) mesh.colours.resize(mesh.vertices.size(), Colour{});
  find_points(mesh);
  return Success{};
}

Result<std::size_t> straighten_edges(TetMesh& mesh, double tolerance) {
  if (Status status = check_file_edges(mesh); !status) return status.error();
  std::size_t curved = 0;
  for (const MeshEdge& edge : mesh.edges) {
    const Eigen::Vector3d &a = mesh.vertices[edge.a], &b = mesh.vertices[edge.b];
    const Eigen::Vector3d middle = 0.5 * (a + b);
    if ((mesh.vertices[edge.point] - middle).norm() > tolerance * (b - a).norm()) ++curved;
    mesh.vertices[edge.point] = middle;
  }
  return curved;
}

std::size_t remove_edge_points(TetMesh& mesh) {
  if (mesh.edges.empty()) return 0;
  const std::vector<bool> gone = edge_point_flags(mesh);
  std::vector<VertexId> new_id(mesh.vertices.size(), -1);
  std::size_t count = 0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (gone[v]) continue;
    new_id[v] = static_cast<VertexId>(count);
    mesh.vertices[count] = mesh.vertices[v];
    if (!mesh.colours.empty()) mesh.colours[count] = mesh.colours[v];
    ++count;
  }
  mesh.vertices.resize(count);
  if (!mesh.colours.empty()) mesh.colours.resize(count);
  for (Tetrahedron& tet : mesh.tetrahedra)
    for (VertexId& v : tet) v = new_id[v];
  for (auto& [name, ids] : mesh.node_sets) {
    std::erase_if(ids, [&](VertexId v) { return gone[v]; });
    for (VertexId& v : ids) v = new_id[v];
  }
  const std::size_t removed = mesh.edges.size();
  mesh.edges.clear();
  mesh.edge_points.clear();
  return removed;
}

std::vector<bool> edge_point_flags(const TetMesh& mesh) {
  if (mesh.edges.empty()) return {};
  std::vector<bool> flags(mesh.vertices.size(), false);
  for (const MeshEdge& edge : mesh.edges) flags[edge.point] = true;
  return flags;
}

const MeshEdge* edge_of_point(const TetMesh& mesh, VertexId point) {
  const auto found =
      std::lower_bound(mesh.edges.begin(), mesh.edges.end(), point,
                       [](const MeshEdge& edge, VertexId id) { return edge.point < id; });
  return found != mesh.edges.end() && found->point == point ? &*found : nullptr;
}

std::vector<VertexId> held_edge_points(const TetMesh& mesh, const std::vector<VertexId>& held,
                                       const std::vector<VertexId>& by_place) {
  const auto flags_of = [&mesh](const std::vector<VertexId>& ids) {
    std::vector<bool> flags(mesh.vertices.size(), false);
    for (const VertexId v : ids) flags[v] = true;
    return flags;
  };
  const std::vector<bool> is_held = flags_of(held), placed = flags_of(by_place);
  std::vector<Ends> sides;
  const BoundarySurface boundary = boundary_surface(mesh);
  for (const Triangle& t : boundary.triangles) {
    const auto id = [&](std::size_t corner) { return boundary.vertex_ids[t[corner % 3]]; };
    if (!is_held[id(0)] || !is_held[id(1)] || !is_held[id(2)]) continue;
    for (std::size_t c = 0; c < 3; ++c) sides.push_back(std::minmax({id(c), id(c + 1)}));
  }
  std::sort(sides.begin(), sides.end());
  std::vector<VertexId> points;
  for (const MeshEdge& edge : mesh.edges) {
    if (!is_held[edge.a] || !is_held[edge.b]) continue;
    if ((placed[edge.a] && placed[edge.b]) ||
        std::binary_search(sides.begin(), sides.end(), Ends{edge.a, edge.b}))
      points.push_back(edge.point);
  }
  return points;
}

BoundarySurface subdivided(const BoundarySurface& boundary, const TetMesh& mesh) {
  std::vector<std::pair<Ends, VertexId>> points;
  for (const MeshEdge& edge : mesh.edges) points.push_back({{edge.a, edge.b}, edge.point});
  std::sort(points.begin(), points.end());
  const auto middle = [&](VertexId a, VertexId b) {
    const Ends ends = std::minmax({a, b});
    return std::lower_bound(points.begin(), points.end(), std::pair{ends, VertexId{-1}})->second;
  };
  std::vector<Triangle> triangles;
  for (const Triangle& t : boundary.triangles) {
    const VertexId a = boundary.vertex_ids[t[0]], b = boundary.vertex_ids[t[1]],
                   c = boundary.vertex_ids[t[2]];
    const VertexId ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    triangles.insert(triangles.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
  }
  BoundarySurface fine;
  for (const Triangle& t : triangles)
    fine.vertex_ids.insert(fine.vertex_ids.end(), t.begin(), t.end());
  std::sort(fine.vertex_ids.begin(), fine.vertex_ids.end());
  fine.vertex_ids.erase(std::unique(fine.vertex_ids.begin(), fine.vertex_ids.end()),
                        fine.vertex_ids.end());
  const auto place = [&fine](VertexId id) {
    const auto at = std::lower_bound(fine.vertex_ids.begin(), fine.vertex_ids.end(), id);
    return static_cast<VertexId>(at - fine.vertex_ids.begin());
  };
  for (Triangle& t : triangles) t = {place(t[0]), place(t[1]), place(t[2])};
  fine.triangles = std::move(triangles);
  return fine;
}

namespace {

// An edge between two opposite ones of the octahedron, and the ring of its other four corners, as
// indices into the edges of a tetrahedron.
struct Diagonal {
  std::array<std::size_t, 2> ends;
  std::array<std::size_t, 4> ring;
};
constexpr std::array<Diagonal, 3> kDiagonals = {
    {{{0, 5}, {1, 2, 4, 3}}, {{1, 4}, {0, 2, 5, 3}}, {{2, 3}, {0, 1, 5, 4}}}};

}  // namespace

TetMesh refined_mesh(const TetMesh& mesh) {
  TetMesh fine;
  fine.vertices = mesh.vertices;
  fine.node_sets = mesh.node_sets;
  fine.colours = mesh.colours;
  fine.region_names = mesh.region_names;
  fine.tetrahedra.reserve(8 * mesh.tetrahedra.size());
  const auto add = [&fine](Tetrahedron tet) {
    if (signed_volume(fine, tet) < 0) std::swap(tet[2], tet[3]);
    fine.tetrahedra.push_back(tet);
  };
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    const Tetrahedron& corner = mesh.tetrahedra[t];
    const TetEdges& edge = mesh.edge_points[t];
    add({corner[0], edge[0], edge[1], edge[2]});
    add({edge[0], corner[1], edge[3], edge[4]});
    add({edge[1], edge[3], corner[2], edge[5]});
    add({edge[2], edge[4], edge[5], corner[3]});
    const Diagonal* shortest = nullptr;
    double least = 0;
    for (const Diagonal& each : kDiagonals) {
      const double length =
          (mesh.vertices[edge[each.ends[0]]] - mesh.vertices[edge[each.ends[1]]]).squaredNorm();
      if (shortest != nullptr && length >= least) continue;
      shortest = &each;
      least = length;
    }
    for (std::size_t k = 0; k < 4; ++k)
      add({edge[shortest->ends[0]], edge[shortest->ends[1]], edge[shortest->ring[k]],
           edge[shortest->ring[(k + 1) % 4]]});
    if (!mesh.region_of.empty()) fine.region_of.insert(fine.region_of.end(), 8, mesh.region_of[t]);
  }
  return fine;
}

}  // namespace tremolo
