#include "precompute/mesher/surface/surface_weld.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <unordered_map>
#include <vector>

namespace tremolo {
namespace {

using Point = Eigen::Vector3d;

constexpr double kGap = 3e-5;
// A gap that is closed is at most this share of the short edges.
constexpr double kGapOverEdge = 0.1;
// Height over the longest edge of a triangle that counts as flat.
constexpr double kFlat = 1e-9;

std::uint64_t cell_key(const Eigen::Vector3i& cell) {
  std::uint64_t value = 0;
  for (const int c : cell) value = (value << 21) | (static_cast<std::uint64_t>(c) & 0x1fffffu);
  return value;
}

void renumber(SurfaceMesh& surface, const std::vector<VertexId>& place_of) {
  for (Triangle& t : surface.triangles)
    for (VertexId& v : t) v = place_of[static_cast<std::size_t>(v)];
}

std::size_t merge_equal(SurfaceMesh& surface) {
  std::map<std::array<double, 3>, VertexId> first;
  std::vector<VertexId> place_of(surface.vertices.size());
  std::vector<Point> kept;
  for (std::size_t v = 0; v < place_of.size(); ++v) {
    const Point& x = surface.vertices[v];
    const auto [at, fresh] =
        first.try_emplace({x[0] + 0.0, x[1] + 0.0, x[2] + 0.0}, static_cast<VertexId>(kept.size()));
    if (fresh) kept.push_back(x);
    place_of[v] = at->second;
  }
  const std::size_t merged = surface.vertices.size() - kept.size();
  surface.vertices = std::move(kept);
  renumber(surface, place_of);
  return merged;
}

// Each vertex goes to the first one within `gap` that itself stays.
std::size_t merge_near(SurfaceMesh& surface, double gap) {
  std::unordered_map<std::uint64_t, std::vector<VertexId>> cells;
  std::vector<VertexId> place_of(surface.vertices.size());
  std::vector<Point> kept;
  for (std::size_t v = 0; v < place_of.size(); ++v) {
    const Point& x = surface.vertices[v];
    const Eigen::Vector3i cell = (x / gap).array().floor().cast<int>();
    VertexId found = -1;
    for (int i = 0; i < 27 && found < 0; ++i) {
      const auto at =
          cells.find(cell_key(cell + Eigen::Vector3i(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)));
      if (at == cells.end()) continue;
      for (const VertexId other : at->second)
        if ((kept[static_cast<std::size_t>(other)] - x).norm() <= gap) {
          found = other;
          break;
        }
    }
    if (found < 0) {
      found = static_cast<VertexId>(kept.size());
      kept.push_back(x);
      cells[cell_key(cell)].push_back(found);
    }
    place_of[v] = found;
  }
  const std::size_t merged = surface.vertices.size() - kept.size();
  surface.vertices = std::move(kept);
  renumber(surface, place_of);
  return merged;
}

bool is_flat(const SurfaceMesh& surface, const Triangle& t) {
  if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return true;
  const auto at = [&](std::size_t i) -> const Point& {
    return surface.vertices[static_cast<std::size_t>(t[i])];
  };
  const Point a = at(1) - at(0), b = at(2) - at(0), c = at(2) - at(1);
  const double longest = std::max({a.norm(), b.norm(), c.norm()});
  return !(a.cross(b).norm() > kFlat * longest * longest);
}

std::size_t drop_flat(SurfaceMesh& surface) {
  return std::erase_if(surface.triangles, [&](const Triangle& t) { return is_flat(surface, t); });
}

// A fifth percentile of the edges' lengths: one bad edge must not decide.
double short_edge(const SurfaceMesh& surface) {
  std::vector<double> lengths;
  for (const Triangle& t : surface.triangles)
    for (std::size_t i = 0; i < 3; ++i)
      lengths.push_back((surface.vertices[static_cast<std::size_t>(t[i])] -
                         surface.vertices[static_cast<std::size_t>(t[(i + 1) % 3])])
                            .norm());
  if (lengths.empty()) return 0.0;
  const auto at = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 20);
  std::nth_element(lengths.begin(), at, lengths.end());
  return *at;
}

Triangle sorted(Triangle t) {
  std::sort(t.begin(), t.end());
  return t;
}

bool is_even(const Triangle& t) {
  return ((t[0] < t[1]) + (t[1] < t[2]) + (t[2] < t[0])) == 2;
}

struct Faces {
  std::vector<Triangle> alone;         // each once
  std::vector<Triangle> back_to_back;  // one of each pair
  std::size_t repeated = 0;
};

Faces sort_out(const SurfaceMesh& surface) {
  struct Seen {
    Triangle first;
    std::size_t even = 0, odd = 0;
  };
  std::map<Triangle, std::size_t> place_of;
  std::vector<Seen> seen;
  for (const Triangle& t : surface.triangles) {
    const auto [at, fresh] = place_of.try_emplace(sorted(t), seen.size());
    if (fresh) seen.push_back({t});
    ++(is_even(t) ? seen[at->second].even : seen[at->second].odd);
  }
  Faces faces;
  for (const Seen& face : seen) {
    const bool both = face.even > 0 && face.odd > 0;
    (both ? faces.back_to_back : faces.alone).push_back(face.first);
    faces.repeated += face.even + face.odd - (both ? 2 : 1);
  }
  return faces;
}

}  // namespace

void drop_unused_vertices(SurfaceMesh& surface) {
  std::vector<VertexId> place_of(surface.vertices.size(), -1);
  for (const Triangle& t : surface.triangles)
    for (const VertexId v : t) place_of[static_cast<std::size_t>(v)] = 0;
  std::vector<Point> kept;
  for (std::size_t v = 0; v < place_of.size(); ++v)
    if (place_of[v] == 0) {
      place_of[v] = static_cast<VertexId>(kept.size());
      kept.push_back(surface.vertices[v]);
    }
  surface.vertices = std::move(kept);
  renumber(surface, place_of);
}

std::size_t odd_edges(const SurfaceMesh& surface) {
  std::vector<std::pair<VertexId, VertexId>> edges;
  edges.reserve(3 * surface.triangles.size());
  for (const Triangle& t : surface.triangles)
    for (std::size_t i = 0; i < 3; ++i) edges.push_back(std::minmax({t[i], t[(i + 1) % 3]}));
  std::sort(edges.begin(), edges.end());
  std::size_t count = 0;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t next = i;
    while (next < edges.size() && edges[next] == edges[i]) ++next;
    count += (next - i) % 2;
    i = next;
  }
  return count;
}

WeldCounts weld(SurfaceMesh& surface) {
  WeldCounts counts;
  drop_unused_vertices(surface);
  counts.welded = merge_equal(surface);
  counts.degenerate = drop_flat(surface);
  drop_unused_vertices(surface);
  const std::size_t open = odd_edges(surface);
  if (open > 0) {
    SurfaceMesh closed = surface;
    const double gap = std::min(kGap, kGapOverEdge * short_edge(surface));
    const std::size_t merged = gap > 0 ? merge_near(closed, gap) : 0;
    const std::size_t flat = drop_flat(closed);
    if (merged > 0 && odd_edges(closed) < open) {
      surface = std::move(closed);
      counts.welded += merged;
      counts.degenerate += flat;
    }
  }
  Faces faces = sort_out(surface);
  counts.repeated = faces.repeated;
  surface.triangles = faces.alone;
  if (!faces.back_to_back.empty()) {
    SurfaceMesh with = surface;
    with.triangles.insert(with.triangles.end(), faces.back_to_back.begin(),
                          faces.back_to_back.end());
    if (surface.triangles.empty() || odd_edges(with) <= odd_edges(surface)) {
      surface = std::move(with);
      counts.repeated += faces.back_to_back.size();
    } else {
      counts.cancelled = 2 * faces.back_to_back.size();
    }
  }
  drop_unused_vertices(surface);
  return counts;
}

}  // namespace tremolo
