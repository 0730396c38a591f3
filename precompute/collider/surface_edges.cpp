#include "precompute/collider/surface_edges.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <tuple>
#include <utility>

namespace tremolo {
namespace {

// A triangle's edge between a < b; forward: the triangle goes from a to b.
struct EdgeUse {
  VertexId a = 0;
  VertexId b = 0;
  std::size_t triangle = 0;
  bool forward = false;
};

// Sorted by edge, then by triangle.
std::vector<EdgeUse> edge_uses(const SurfaceMesh& surface) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const VertexId from = surface.triangles[t][k], to = surface.triangles[t][(k + 1) % 3];
      uses.push_back({std::min(from, to), std::max(from, to), t, from < to});
    }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& x, const EdgeUse& y) {
    return std::tie(x.a, x.b, x.triangle) < std::tie(y.a, y.b, y.triangle);
  });
  return uses;
}

// Calls visit(first, last) for the uses of each edge.
template <class Visit>
void for_each_edge(const std::vector<EdgeUse>& uses, const Visit& visit) {
  for (std::size_t first = 0, last = 0; first < uses.size(); first = last) {
    while (last < uses.size() && uses[last].a == uses[first].a && uses[last].b == uses[first].b)
      ++last;
    visit(first, last);
  }
}

struct EdgeNeighbour {
  std::size_t triangle;
  bool agrees;  // passes the edge in the opposite direction
};
using EdgeNeighbours = std::vector<std::vector<EdgeNeighbour>>;

EdgeNeighbours edge_neighbours(const SurfaceMesh& surface) {
  EdgeNeighbours neighbours(surface.triangles.size());
  const std::vector<EdgeUse> uses = edge_uses(surface);
  for_each_edge(uses, [&](std::size_t first, std::size_t last) {
    if (last - first != 2) return;
    const EdgeUse &one = uses[first], &other = uses[first + 1];
    const bool agrees = one.forward != other.forward;
    neighbours[one.triangle].push_back({other.triangle, agrees});
    neighbours[other.triangle].push_back({one.triangle, agrees});
  });
  return neighbours;
}

double area_of(const SurfaceMesh& surface, std::size_t triangle) {
  const Triangle& t = surface.triangles[triangle];
  const Eigen::Vector3d& a = surface.vertices[t[0]];
  return 0.5 * (surface.vertices[t[1]] - a).cross(surface.vertices[t[2]] - a).norm();
}

enum class Side : std::uint8_t { kUnknown, kAsDrawn, kTurned };

Side other_side(Side side) {
  return side == Side::kTurned ? Side::kAsDrawn : Side::kTurned;
}

// Finds the triangles connected with `start`, and the side of each; false: two paths to a triangle
// contradict each other.
bool spread_side(const EdgeNeighbours& neighbours, std::size_t start, std::vector<Side>& sides,
                 std::vector<std::size_t>& patch) {
  bool consistent = true;
  patch = {start};
  sides[start] = Side::kAsDrawn;
  for (std::size_t at = 0; at < patch.size(); ++at)
    for (const EdgeNeighbour& next : neighbours[patch[at]]) {
      const Side wanted = next.agrees ? sides[patch[at]] : other_side(sides[patch[at]]);
      if (sides[next.triangle] == Side::kUnknown) {
        sides[next.triangle] = wanted;
        patch.push_back(next.triangle);
      } else if (sides[next.triangle] != wanted) {
        consistent = false;
      }
    }
  return consistent;
}

using DirectedEdge = std::pair<VertexId, VertexId>;

std::vector<DirectedEdge> unmatched_edges(const SurfaceMesh& surface) {
  std::vector<DirectedEdge> edges;
  const std::vector<EdgeUse> uses = edge_uses(surface);
  for_each_edge(uses, [&](std::size_t first, std::size_t last) {
    std::ptrdiff_t surplus = 0;
    for (std::size_t i = first; i < last; ++i) surplus += uses[i].forward ? 1 : -1;
    const auto& [a, b] = std::pair(uses[first].a, uses[first].b);
    for (; surplus > 0; --surplus) edges.emplace_back(a, b);
    for (; surplus < 0; ++surplus) edges.emplace_back(b, a);
  });
  std::sort(edges.begin(), edges.end());
  return edges;
}

}  // namespace

Orientation orient_triangles(SurfaceMesh& surface) {
  const EdgeNeighbours neighbours = edge_neighbours(surface);
  std::vector<Side> sides(surface.triangles.size(), Side::kUnknown);
  std::vector<std::size_t> patch;
  Orientation found;
  for (std::size_t start = 0; start < sides.size(); ++start) {
    if (sides[start] != Side::kUnknown) continue;
    if (!spread_side(neighbours, start, sides, patch)) found.one_sided = true;
    double drawn = 0.0, turned = 0.0;
    for (const std::size_t t : patch)
      (sides[t] == Side::kTurned ? turned : drawn) += area_of(surface, t);
    const Side minority = turned > drawn ? Side::kAsDrawn : Side::kTurned;
    for (const std::size_t t : patch) {
      if (sides[t] != minority) continue;
      std::swap(surface.triangles[t][1], surface.triangles[t][2]);
      ++found.turned;
    }
  }
  return found;
}

// The number of unmatched edges into a vertex is that of edges out of it, so that every walk is
// closed.
std::vector<std::vector<VertexId>> boundary_loops(const SurfaceMesh& surface) {
  const std::vector<DirectedEdge> edges = unmatched_edges(surface);
  std::vector<std::size_t> next(surface.vertices.size());  // unused edge of each vertex
  for (std::size_t v = 0; v < next.size(); ++v)
    next[v] =
        std::lower_bound(edges.begin(), edges.end(), DirectedEdge{static_cast<VertexId>(v), 0}) -
        edges.begin();
  const auto has_edge = [&](VertexId v) {
    return next[v] < edges.size() && edges[next[v]].first == v;
  };
  std::vector<std::vector<VertexId>> loops;
  std::vector<bool> on_path(surface.vertices.size(), false);
  for (const DirectedEdge& edge : edges) {
    std::vector<VertexId> path;
    for (VertexId at = edge.first; has_edge(at);) {
      path.push_back(at);
      on_path[at] = true;
      at = edges[next[at]++].second;
      if (!on_path[at]) continue;
      const auto begin = std::find(path.begin(), path.end(), at);
      for (auto v = begin; v != path.end(); ++v) on_path[*v] = false;
      loops.emplace_back(begin, path.end());
      path.erase(begin, path.end());
    }
    for (const VertexId v : path) on_path[v] = false;
  }
  return loops;
}

}  // namespace tremolo
