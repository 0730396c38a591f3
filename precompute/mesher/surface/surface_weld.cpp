#include <algorithm>
#include <map>
#include <numeric>
#include <vector>

#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>

#include "common/mesh/point_cells.h"
#include "precompute/mesher/surface/repair_steps.h"
#include "precompute/mesher/surface/surface_geometry.h"

namespace tremolo {
namespace {

using Point = Eigen::Vector3d;

// The largest distance between vertices of a gap that is closed, relative to the diagonal and to
// the short edges' length.
constexpr double kGap = 3e-5;
constexpr double kGapOverEdge = 0.1;
// Height over the longest edge of a triangle that counts as flat.
constexpr double kFlat = 1e-9;

// What CGAL's functions for soups of triangles need to know of a point.
struct SoupTraits {
  using Point_3 = Point;
  struct Less_xyz_3 {
    bool operator()(const Point& a, const Point& b) const {
      return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
    }
  };
  Less_xyz_3 less_xyz_3_object() const { return {}; }
};

void renumber(SurfaceMesh& surface, const std::vector<VertexId>& new_ids) {
  for (Triangle& t : surface.triangles)
    for (VertexId& v : t) v = new_ids[v];
}

// Moves each vertex to the first one nearer than `gap` that itself stays.
std::size_t merge_near(SurfaceMesh& surface, double gap) {
  PointCells cells(gap);
  std::vector<VertexId> new_ids;
  for (const Point& x : surface.vertices) {
    const VertexId found = cells.near(x, gap);
    new_ids.push_back(found < 0 ? cells.add(x) : found);
  }
  const std::size_t merged = surface.vertices.size() - cells.points().size();
  surface.vertices = cells.points();
  renumber(surface, new_ids);
  return merged;
}

bool is_flat(const SurfaceMesh& surface, const Triangle& t) {
  if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return true;
  const auto [a, b, c] = corners(surface, t);
  const double longest = std::max({(b - a).norm(), (c - a).norm(), (c - b).norm()});
  return !(doubled_area(surface, t).norm() > kFlat * longest * longest);
}

// Removes the triangles for which drop(t), by index, is true, and their entries of `origin`.
template <class Drop>
std::size_t drop_triangles(SurfaceMesh& surface, std::vector<std::size_t>& origin,
                           const Drop& drop) {
  std::size_t kept = 0;
  const std::size_t count = surface.triangles.size();
  for (std::size_t t = 0; t < count; ++t) {
    if (drop(t)) continue;
    surface.triangles[kept] = surface.triangles[t];
    origin[kept++] = origin[t];
  }
  surface.triangles.resize(kept);
  origin.resize(kept);
  return count - kept;
}

std::size_t drop_flat(SurfaceMesh& surface, std::vector<std::size_t>& origin) {
  return drop_triangles(surface, origin,
                        [&](std::size_t t) { return is_flat(surface, surface.triangles[t]); });
}

// The fifth percentile of the edges' lengths, so that one bad edge does not decide; 0 without
// edges.
double short_edge(const SurfaceMesh& surface) {
  std::vector<double> lengths;
  for (const Triangle& t : surface.triangles) {
    const auto [a, b, c] = corners(surface, t);
    lengths.insert(lengths.end(), {(a - b).norm(), (b - c).norm(), (c - a).norm()});
  }
  if (lengths.empty()) return 0.0;
  const auto at = lengths.begin() + lengths.size() / 20;
  std::nth_element(lengths.begin(), at, lengths.end());
  return *at;
}

// Merges vertices that are close to each other if that leaves fewer open edges.
void close_gaps(SurfaceMesh& surface, WeldCounts& counts) {
  const std::size_t open = odd_edges(surface);
  if (open == 0) return;
  SurfaceMesh closed = surface;
  std::vector<std::size_t> origin = counts.origin;
  const double gap = std::min(kGap, kGapOverEdge * short_edge(surface));
  const std::size_t merged = gap > 0 ? merge_near(closed, gap) : 0;
  const std::size_t flat = drop_flat(closed, origin);
  if (merged == 0 || odd_edges(closed) >= open) return;
  surface = std::move(closed);
  counts.origin = std::move(origin);
  counts.welded += merged;
  counts.degenerate += flat;
}

Triangle sorted(Triangle t) {
  std::sort(t.begin(), t.end());
  return t;
}

bool is_even(const Triangle& t) {
  return ((t[0] < t[1]) + (t[1] < t[2]) + (t[2] < t[0])) == 2;
}

// Leaves the first of several equal triangles; of those back to back with another one of each pair,
// at the end, or neither where that leaves fewer open edges.
void drop_repeats(SurfaceMesh& surface, WeldCounts& counts) {
  struct Uses {
    std::size_t even = 0, odd = 0;
    std::size_t first = 0;  // of the given triangles
  };
  std::map<Triangle, Uses> uses;
  auto& triangles = surface.triangles;
  std::vector<WeldedTwin> twins;
  counts.repeated = drop_triangles(surface, counts.origin, [&](std::size_t t) {
    Uses& of_these = uses[sorted(triangles[t])];
    if (of_these.even + of_these.odd == 0)
      of_these.first = counts.origin[t];
    else
      twins.push_back({counts.origin[t], of_these.first});
    ++(is_even(triangles[t]) ? of_these.even : of_these.odd);
    return of_these.even + of_these.odd > 1;
  });
  counts.twins = std::move(twins);
  const auto is_pair = [&](const Triangle& t) {
    const Uses& of_these = uses[sorted(t)];
    return of_these.even > 0 && of_these.odd > 0;
  };
  const std::size_t pairs = std::count_if(triangles.begin(), triangles.end(), is_pair);
  if (pairs == 0) return;
  SurfaceMesh without = surface;
  std::vector<std::size_t> origin = counts.origin, pair_origin;
  std::vector<Triangle> back_to_back;
  drop_triangles(without, origin, [&](std::size_t t) {
    if (!is_pair(triangles[t])) return false;
    back_to_back.push_back(triangles[t]);
    pair_origin.push_back(counts.origin[t]);
    return true;
  });
  if (!without.triangles.empty() && odd_edges(surface) > odd_edges(without)) {
    counts.repeated -= pairs;
    counts.cancelled = 2 * pairs;
    surface = std::move(without);
    counts.origin = std::move(origin);
    return;
  }
  // The pairs are last.
  surface.triangles = std::move(without.triangles);
  surface.triangles.insert(surface.triangles.end(), back_to_back.begin(), back_to_back.end());
  counts.origin = std::move(origin);
  counts.origin.insert(counts.origin.end(), pair_origin.begin(), pair_origin.end());
}

}  // namespace

void drop_unused_vertices(SurfaceMesh& surface) {
  std::vector<VertexId> new_ids(surface.vertices.size(), -1);
  for (const Triangle& t : surface.triangles)
    for (const VertexId v : t) new_ids[v] = 0;
  std::vector<Point> kept;
  for (std::size_t v = 0; v < new_ids.size(); ++v)
    if (new_ids[v] == 0) {
      new_ids[v] = static_cast<VertexId>(kept.size());
      kept.push_back(surface.vertices[v]);
    }
  surface.vertices = std::move(kept);
  renumber(surface, new_ids);
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
  counts.origin.resize(surface.triangles.size());
  std::iota(counts.origin.begin(), counts.origin.end(), 0);
  drop_unused_vertices(surface);
  counts.welded = CGAL::Polygon_mesh_processing::merge_duplicate_points_in_polygon_soup(
      surface.vertices, surface.triangles, CGAL::parameters::geom_traits(SoupTraits{}));
  counts.degenerate = drop_flat(surface, counts.origin);
  drop_unused_vertices(surface);
  close_gaps(surface, counts);
  drop_repeats(surface, counts);
  drop_unused_vertices(surface);
  return counts;
}

}  // namespace tremolo
