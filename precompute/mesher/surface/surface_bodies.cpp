#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "precompute/mesher/surface/repair_steps.h"
#include "precompute/mesher/surface/surface_geometry.h"

namespace tremolo {
namespace {

using Point = Eigen::Vector3d;

// More are not united.
constexpr std::size_t kMostBodies = 200;
// Triangles at an edge whose planes differ by a smaller angle lie on each other.
constexpr double kSameAngle = 1e-5;

// Disjoint sets of indices.
class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  std::size_t find(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t i, std::size_t j) { parent_[find(i)] = find(j); }
  // A number from 0 for the set of each index, in the order of the indices.
  std::vector<std::uint32_t> labels() {
    std::map<std::size_t, std::uint32_t> number;
    std::vector<std::uint32_t> result;
    for (std::size_t i = 0; i < parent_.size(); ++i)
      result.push_back(
          number.emplace(find(i), static_cast<std::uint32_t>(number.size())).first->second);
    return result;
  }

 private:
  std::vector<std::size_t> parent_;
};

// Triangles that use the same vertices, directly or through others.
std::vector<std::uint32_t> parts_by_vertices(const SurfaceMesh& surface) {
  Sets sets(surface.vertices.size());
  for (const Triangle& t : surface.triangles) sets.join(t[0], t[1]), sets.join(t[0], t[2]);
  std::map<std::size_t, std::uint32_t> number;
  std::vector<std::uint32_t> parts;
  for (const Triangle& t : surface.triangles)
    parts.push_back(
        number.emplace(sets.find(t[0]), static_cast<std::uint32_t>(number.size())).first->second);
  return parts;
}

// A use of an edge by a triangle, and the direction of the triangle around the edge.
struct Side {
  std::size_t triangle;
  bool closes;   // the inside ends here, counter-clockwise about the edge from low to high
  double angle;  // from the first side, 0 to 2 pi
};

std::vector<Side> sides_around(const SurfaceMesh& surface, std::span<const SurfaceEdge> uses) {
  const Point origin = surface.vertices[uses[0].low];
  const Point axis = (surface.vertices[uses[0].high] - origin).normalized();
  std::vector<Side> sides;
  Point right = Point::Zero(), up = Point::Zero();
  for (const SurfaceEdge& use : uses) {
    Point out = Point::Zero();
    for (const VertexId v : surface.triangles[use.triangle])
      if (v != use.low && v != use.high) out = surface.vertices[v] - origin;
    out = (out - axis.dot(out) * axis).normalized();
    if (sides.empty()) right = out, up = axis.cross(out);
    double angle = std::atan2(out.dot(up), out.dot(right));
    if (angle < -kSameAngle) angle += 2.0 * std::numbers::pi;
    sides.push_back({use.triangle, use.forward, angle});
  }
  std::sort(sides.begin(), sides.end(),
            [](const Side& a, const Side& b) { return a.angle < b.angle; });
  // Of sides that lie on each other those of the body before them come first.
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t next = i + 1;
    while (next < sides.size() && sides[next].angle - sides[i].angle < kSameAngle) ++next;
    std::stable_partition(sides.begin() + i, sides.begin() + next,
                          [](const Side& side) { return side.closes; });
    i = next;
  }
  return sides;
}

// Joins the triangles of an edge that have the inside between them. False if there are none such.
bool join_across(const SurfaceMesh& surface, std::span<const SurfaceEdge> uses, Sets& sets) {
  if (uses.size() % 2 != 0) return false;
  std::vector<Side> sides = sides_around(surface, uses);
  int depth = 0, least = 0;
  std::size_t start = 0;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    depth += sides[i].closes ? -1 : 1;
    if (depth < least) least = depth, start = i + 1;
  }
  if (depth != 0) return false;
  std::rotate(sides.begin(), sides.begin() + start, sides.end());
  std::vector<std::size_t> open;
  for (const Side& side : sides) {
    if (!side.closes) {
      open.push_back(side.triangle);
      continue;
    }
    sets.join(open.back(), side.triangle);
    open.pop_back();
  }
  return true;
}

// The closed shells of a part that faces outwards, one label per triangle; none if it has others.
std::optional<std::vector<std::uint32_t>> shells_of(const SurfaceMesh& surface) {
  Sets sets(surface.triangles.size());
  bool closed = true;
  for_each_edge(sorted_edges(surface.triangles), [&](std::span<const SurfaceEdge> uses) {
    closed = closed && join_across(surface, uses, sets);
  });
  if (!closed) return std::nullopt;
  return sets.labels();
}

// Adds a part's shells to `whole` and `shell_of`, oriented outwards. False if it is not closed.
bool add_part(SurfaceMesh part, const std::vector<std::size_t>& given, SurfaceMesh& whole,
              std::vector<std::size_t>& shell_of, UnitedBodies& result) {
  const WeldCounts counts = weld(part);
  if (part.triangles.empty() || odd_edges(part) > 0) return false;
  const std::vector<Triangle> welded = part.triangles;
  std::vector<std::size_t> patch_of;
  SurfaceFindings findings;
  const std::vector<SurfacePatch> patches = orient_within_patches(part, patch_of, findings);
  if (findings.one_sided_edges > 0) return false;
  double volume = 0;
  for (const SurfacePatch& patch : patches) volume += signed_volume(part, patch);
  if (volume < 0)
    for (const SurfacePatch& patch : patches) turn_patch(part, patch);
  const std::optional<std::vector<std::uint32_t>> shells = shells_of(part);
  if (!shells) return false;
  const std::size_t first_shell = result.bodies;
  const auto first_vertex = static_cast<VertexId>(whole.vertices.size());
  whole.vertices.insert(whole.vertices.end(), part.vertices.begin(), part.vertices.end());
  for (std::size_t t = 0; t < part.triangles.size(); ++t) {
    const auto [a, b, c] = part.triangles[t];
    whole.triangles.push_back({a + first_vertex, b + first_vertex, c + first_vertex});
    shell_of.push_back(first_shell + (*shells)[t]);
    result.bodies = std::max(result.bodies, shell_of.back() + 1);
    result.turned[given[counts.origin[t]]] = part.triangles[t] != welded[t];
  }
  for (const WeldedTwin& twin : counts.twins)
    result.turned[given[twin.dropped]] = result.turned[given[twin.first]];
  result.counts.welded += counts.welded;
  result.counts.degenerate += counts.degenerate;
  result.counts.repeated += counts.repeated;
  result.counts.cancelled += counts.cancelled;
  return true;
}

// The union of the shells of the parts, which part_of labels from 0.
std::optional<UnitedBodies> unite_parts(const SurfaceMesh& given,
                                        const std::vector<std::uint32_t>& part_of) {
  std::map<std::uint32_t, std::vector<std::size_t>> parts;
  for (std::size_t t = 0; t < part_of.size(); ++t) {
    parts[part_of[t]].push_back(t);
    if (parts.size() > kMostBodies) return std::nullopt;
  }
  UnitedBodies result;
  result.turned.assign(given.triangles.size(), 0);
  SurfaceMesh whole;
  std::vector<std::size_t> shell_of;
  for (const auto& [label, triangles] : parts) {
    SurfaceMesh part{given.vertices, {}};
    for (const std::size_t t : triangles) part.triangles.push_back(given.triangles[t]);
    if (!add_part(std::move(part), triangles, whole, shell_of, result)) return std::nullopt;
  }
  std::optional<SurfaceMesh> united = unite_shells(whole, shell_of);
  if (!united) return std::nullopt;
  result.mesh = std::move(*united);
  return result;
}

}  // namespace

std::size_t count_hinges(const SurfaceMesh& surface) {
  std::size_t hinges = 0;
  bool others = false;
  for_each_edge(sorted_edges(surface.triangles), [&](std::span<const SurfaceEdge> uses) {
    if (uses.size() == 2) return;
    others = others || uses.size() % 2 != 0;
    if (others) return;
    const std::vector<Side> sides = sides_around(surface, uses);
    for (std::size_t i = 1; i < sides.size(); ++i)
      others = others || std::abs(sides[i].angle - sides[i - 1].angle) < kSameAngle;
    ++hinges;
  });
  return others ? 0 : hinges;
}

std::optional<UnitedBodies> unite_bodies(const SurfaceMesh& given,
                                         const std::vector<std::uint32_t>& object_of) {
  if (object_of.size() == given.triangles.size())
    if (std::optional<UnitedBodies> united = unite_parts(given, object_of)) return united;
  if (std::optional<UnitedBodies> united = unite_parts(given, parts_by_vertices(given)))
    return united;
  return unite_parts(given, std::vector<std::uint32_t>(given.triangles.size(), 0));
}

}  // namespace tremolo
