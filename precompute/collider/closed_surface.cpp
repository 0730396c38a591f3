#include "precompute/collider/closed_surface.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/mesh/winding_number.h"
#include "common/parallel.h"
#include "common/text.h"
#include "common/union_find.h"
#include "precompute/collider/surface_edges.h"
#include "precompute/embedding/box_tree.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

// Vertices closer to each other than this, relative to the diagonal, are joined.
constexpr double kSamePlace = 1e-6;
// Distance from a triangle, relative to the diagonal, at which its two sides are sampled.
constexpr double kBeside = 1e-5;

// The vertex with the lowest number at each vertex's position.
std::vector<VertexId> first_at_place(const std::vector<Vector3d>& vertices, double reach) {
  std::vector<BoundingBox> boxes;
  boxes.reserve(vertices.size());
  for (const Vector3d& x : vertices) boxes.push_back({x, x});
  const BoxTree tree(boxes);
  constexpr VertexId kNone = -1;
  std::vector<VertexId> first(vertices.size(), kNone);
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    if (first[v] != kNone) continue;
    tree.visit_near(vertices[v], reach * reach, [&](std::size_t other) {
      const bool near = (vertices[other] - vertices[v]).squaredNorm() <= reach * reach;
      if (near && first[other] == kNone) first[other] = static_cast<VertexId>(v);
    });
  }
  return first;
}

// Joins vertices and keeps the used ones, and triangles with three different corners.
SurfaceMesh weld(const RenderSurface& given) {
  const double diagonal = bounding_box(given.vertices).diagonal();
  const std::vector<VertexId> first = first_at_place(given.vertices, kSamePlace * diagonal);
  std::vector<VertexId> number(given.vertices.size(), -1);
  SurfaceMesh surface;
  for (const Triangle& t : given.triangles) {
    const Triangle corners = {first[t[0]], first[t[1]], first[t[2]]};
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
    Triangle renumbered{};
    for (std::size_t k = 0; k < 3; ++k) {
      VertexId& id = number[corners[k]];
      if (id < 0) {
        id = static_cast<VertexId>(surface.vertices.size());
        surface.vertices.push_back(given.vertices[corners[k]]);
      }
      renumbered[k] = id;
    }
    surface.triangles.push_back(renumbered);
  }
  return surface;
}

// A fan around the loop's middle, wound against the loop.
void fill_hole(const std::vector<VertexId>& loop, SurfaceMesh& surface) {
  if (loop.size() == 3) {
    surface.triangles.push_back({loop[2], loop[1], loop[0]});
    return;
  }
  Vector3d middle = Vector3d::Zero();
  for (const VertexId v : loop) middle += surface.vertices[v] / static_cast<double>(loop.size());
  const auto centre = static_cast<VertexId>(surface.vertices.size());
  surface.vertices.push_back(middle);
  for (std::size_t i = 0; i < loop.size(); ++i)
    surface.triangles.push_back({loop[(i + 1) % loop.size()], loop[i], centre});
}

Status fill_holes(bool any_hole, double diagonal, ClosedSurface& result) {
  const std::vector<std::vector<VertexId>> loops = boundary_loops(result.surface);
  for (const std::vector<VertexId>& loop : loops) {
    std::vector<Vector3d> places;
    for (const VertexId v : loop) places.push_back(result.surface.vertices[v]);
    result.largest_hole = std::max(result.largest_hole, bounding_box(places).diagonal());
  }
  const double share = result.largest_hole / diagonal;
  if (!any_hole && share > kLargestHole)
    return content_error(
        text("the surface is open: a hole of %.3g m, %.3g %% of its size (%.3g %% is closed by "
             "itself). A collider needs an inside: close the surface, give a sheet a thickness, or "
             "--fill-holes",
             result.largest_hole, 100.0 * share, 100.0 * kLargestHole));
  for (const std::vector<VertexId>& loop : loops) fill_hole(loop, result.surface);
  result.holes = loops.size();
  if (result.holes > 0)
    result.notes.push_back(text("%zu holes closed, the largest of %.3g m (%.2g %% of the size)",
                                result.holes, result.largest_hole, 100.0 * share));
  return Success{};
}

double signed_volume_of(const SurfaceMesh& surface, const Triangle& t) {
  const Vector3d& origin = surface.vertices.front();
  return (surface.vertices[t[0]] - origin)
             .dot((surface.vertices[t[1]] - origin).cross(surface.vertices[t[2]] - origin)) /
         6.0;
}

// Parts of a surface, connected by vertices.
struct SurfaceParts {
  std::vector<std::size_t> part_of;  // one per triangle
  std::vector<double> volumes;       // one per part, m^3, with sign
};

SurfaceParts find_parts(const SurfaceMesh& surface) {
  std::vector<VertexId> parent(surface.vertices.size());
  std::iota(parent.begin(), parent.end(), 0);
  for (const Triangle& t : surface.triangles) {
    join_sets(parent, t[0], t[1]);
    join_sets(parent, t[0], t[2]);
  }
  constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::vector<std::size_t> part_of_root(surface.vertices.size(), kNone);
  SurfaceParts parts;
  for (const Triangle& t : surface.triangles) {
    std::size_t& part = part_of_root[root_of(parent, t[0])];
    if (part == kNone) {
      part = parts.volumes.size();
      parts.volumes.push_back(0.0);
    }
    parts.part_of.push_back(part);
    parts.volumes[part] += signed_volume_of(surface, t);
  }
  return parts;
}

// The parts with the more volume face outwards afterwards.
SurfaceParts turn_whole_outwards(SurfaceMesh& surface) {
  SurfaceParts parts = find_parts(surface);
  if (std::accumulate(parts.volumes.begin(), parts.volumes.end(), 0.0) >= 0.0) return parts;
  for (Triangle& corners : surface.triangles) std::swap(corners[1], corners[2]);
  for (double& volume : parts.volumes) volume = -volume;
  return parts;
}

// A part that faces inwards is a cavity if it is inside one that faces outwards; else it is
// reversed.
void turn_parts_outwards(ClosedSurface& result) {
  SurfaceMesh& surface = result.surface;
  const SurfaceParts parts = turn_whole_outwards(surface);
  result.parts = parts.volumes.size();
  SurfaceMesh outward{surface.vertices, {}};
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    if (parts.volumes[parts.part_of[t]] > 0.0) outward.triangles.push_back(surface.triangles[t]);
  const WindingNumber winding(outward);
  std::vector<signed char> turn(result.parts, -1);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const std::size_t part = parts.part_of[t];
    Triangle& corners = surface.triangles[t];
    if (parts.volumes[part] < 0.0 && turn[part] < 0)
      turn[part] = winding.at(surface.vertices[corners[0]]) < 0.5 ? 1 : 0;
    if (turn[part] == 1) std::swap(corners[1], corners[2]);
  }
  result.turned_parts = std::count(turn.begin(), turn.end(), 1);
  if (result.turned_parts > 0)
    result.notes.push_back(
        text("%zu of %zu parts faced inwards and were turned", result.turned_parts, result.parts));
}

// True if both sides of the triangle are inside, at its middle and near its corners.
bool is_buried(const WindingNumber& winding, const SurfaceMesh& surface, const Triangle& t,
               double beside) {
  const Vector3d corners[] = {surface.vertices[t[0]], surface.vertices[t[1]],
                              surface.vertices[t[2]]};
  const Vector3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  if (!(normal.norm() > 0.0)) return false;
  const Vector3d step = beside * normal.normalized();
  const Vector3d middle = (corners[0] + corners[1] + corners[2]) / 3.0;
  const auto inside = [&](const Vector3d& x) {
    return winding.at(x + step) > 0.5 && winding.at(x - step) > 0.5;
  };
  if (!inside(middle)) return false;
  for (const Vector3d& corner : corners)
    if (!inside(0.9 * corner + 0.1 * middle)) return false;
  return true;
}

void find_buried(double diagonal, unsigned threads, ClosedSurface& result) {
  const WindingNumber winding(result.surface);
  std::vector<char>& buried = result.buried;
  buried.assign(result.surface.triangles.size(), 0);
  constexpr std::size_t kChunk = 256;
  parallel_for((buried.size() + kChunk - 1) / kChunk, threads, [&](std::size_t chunk) {
    const std::size_t end = std::min(buried.size(), kChunk * (chunk + 1));
    for (std::size_t t = kChunk * chunk; t < end; ++t)
      buried[t] =
          is_buried(winding, result.surface, result.surface.triangles[t], kBeside * diagonal);
  });
  result.buried_triangles = std::count(buried.begin(), buried.end(), 1);
  if (result.buried_triangles > 0)
    result.notes.push_back(
        text("%zu triangles lie inside of other parts and do not count", result.buried_triangles));
}

}  // namespace

Result<ClosedSurface> close_surface(const RenderSurface& given, bool any_hole, unsigned threads) {
  ClosedSurface result;
  result.surface = weld(given);
  const double diagonal = bounding_box(result.surface.vertices).diagonal();
  if (result.surface.triangles.empty() || !(diagonal > 0.0))
    return content_error("the surface has no triangle with three different corners");
  const Orientation orientation = orient_triangles(result.surface);
  if (orientation.one_sided)
    return content_error("the surface has one side only: nothing says what is inside");
  result.turned_triangles = orientation.turned;
  if (orientation.turned > 0)
    result.notes.push_back(text("%zu of %zu triangles were turned to agree with their neighbours",
                                orientation.turned, result.surface.triangles.size()));
  if (Status status = fill_holes(any_hole, diagonal, result); !status) return status.error();
  turn_parts_outwards(result);
  double volume = 0.0;
  for (const Triangle& t : result.surface.triangles) volume += signed_volume_of(result.surface, t);
  if (!(volume > 1e-9 * diagonal * diagonal * diagonal))
    return content_error(
        "the surface encloses no volume: it is a sheet, or its parts cancel each other");
  find_buried(diagonal, threads, result);
  return result;
}

}  // namespace tremolo
