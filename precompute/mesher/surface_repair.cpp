#include "precompute/mesher/surface_repair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <optional>
#include <queue>
#include <random>
#include <span>
#include <tuple>

#include "precompute/mesher/crossings.h"
#include "precompute/mesher/surface_union.h"
#include "precompute/mesher/surface_weld.h"
#include "precompute/mesher/triangle_tree.h"
#include "precompute/mesher/winding_number.h"

namespace tremolo {
namespace {

using Point = Eigen::Vector3d;

// Rays in all to tell the outside of patches, and the most and least samples a patch.
constexpr std::size_t kSamples = 40'000;
constexpr std::size_t kMostSamples = 64;
constexpr std::size_t kLeastSamples = 2;
constexpr int kRays = 4;  // a side of a sample
constexpr double kOff = 1e-6;

struct Edge {
  VertexId low, high;
  std::size_t triangle;
  bool forward;  // from low to high in the triangle's order
  bool operator<(const Edge& other) const {
    return std::tie(low, high, triangle) < std::tie(other.low, other.high, other.triangle);
  }
  bool same(const Edge& other) const { return low == other.low && high == other.high; }
};

std::vector<Edge> sorted_edges(const std::vector<Triangle>& triangles) {
  std::vector<Edge> edges;
  edges.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      const VertexId a = triangles[t][i], b = triangles[t][(i + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), t, a < b});
    }
  std::sort(edges.begin(), edges.end());
  return edges;
}

// Visits the edges with all their triangles.
template <class Visit>
void for_each_edge(const std::vector<Edge>& edges, const Visit& visit) {
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t next = i;
    while (next < edges.size() && edges[next].same(edges[i])) ++next;
    visit(std::span(edges).subspan(i, next - i));
    i = next;
  }
}

Point area_vector(const SurfaceMesh& surface, const Triangle& t) {
  const Point& a = surface.vertices[static_cast<std::size_t>(t[0])];
  return 0.5 * (surface.vertices[static_cast<std::size_t>(t[1])] - a)
                   .cross(surface.vertices[static_cast<std::size_t>(t[2])] - a);
}

// Six times the volume between a patch and the origin.
double volume_below(const SurfaceMesh& surface, const Triangle& t) {
  return surface.vertices[static_cast<std::size_t>(t[0])].dot(
      surface.vertices[static_cast<std::size_t>(t[1])].cross(
          surface.vertices[static_cast<std::size_t>(t[2])]));
}

struct Patch {
  std::vector<std::size_t> triangles;
  bool open = false;       // has an edge with one triangle
  bool branching = false;  // meets others at an edge
};

// Patches: triangles that are connected by edges with exactly two triangles. Turns them to agree
// within each patch, with the larger area as the file has it.
std::vector<Patch> orient_within_patches(SurfaceMesh& surface, std::vector<std::size_t>& patch_of,
                                         SurfaceFindings& findings) {
  struct Link {
    std::size_t other;
    bool agrees;
  };
  const std::size_t count = surface.triangles.size();
  std::vector<std::vector<Link>> links(count);
  for_each_edge(sorted_edges(surface.triangles), [&](std::span<const Edge> edge) {
    if (edge.size() != 2) return;
    const bool agrees = edge[0].forward != edge[1].forward;
    links[edge[0].triangle].push_back({edge[1].triangle, agrees});
    links[edge[1].triangle].push_back({edge[0].triangle, agrees});
  });
  constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  patch_of.assign(count, kNone);
  std::vector<bool> turned(count, false);
  std::vector<Patch> patches;
  std::size_t conflicts = 0;
  for (std::size_t seed = 0; seed < count; ++seed) {
    if (patch_of[seed] != kNone) continue;
    Patch patch;
    patch_of[seed] = patches.size();
    std::queue<std::size_t> front({seed});
    double turned_area = 0, area = 0;
    while (!front.empty()) {
      const std::size_t t = front.front();
      front.pop();
      patch.triangles.push_back(t);
      const double here = area_vector(surface, surface.triangles[t]).norm();
      area += here;
      if (turned[t]) turned_area += here;
      for (const Link& link : links[t]) {
        const bool wanted = turned[t] == link.agrees;
        if (patch_of[link.other] == kNone) {
          patch_of[link.other] = patches.size();
          turned[link.other] = wanted;
          front.push(link.other);
        } else if (turned[link.other] != wanted) {
          ++conflicts;
        }
      }
    }
    const bool turn_rest = turned_area > 0.5 * area;
    for (const std::size_t t : patch.triangles)
      if (turned[t] != turn_rest) {
        std::swap(surface.triangles[t][1], surface.triangles[t][2]);
        ++findings.turned;
      }
    patches.push_back(std::move(patch));
  }
  findings.one_sided_edges = conflicts / 2;
  return patches;
}

// Closed chains of open edges, and the area of the flattest caps over them.
void find_holes(const SurfaceMesh& surface, const std::vector<std::size_t>& patch_of,
                std::vector<Patch>& patches, SurfaceFindings& findings) {
  std::multimap<VertexId, VertexId> next;
  for_each_edge(sorted_edges(surface.triangles), [&](std::span<const Edge> edge) {
    for (const Edge& e : edge) {
      Patch& patch = patches[patch_of[e.triangle]];
      patch.open = patch.open || edge.size() == 1;
      patch.branching = patch.branching || edge.size() > 2;
    }
    if (edge.size() == 1) {
      const Edge& e = edge.front();
      next.emplace(e.forward ? e.high : e.low, e.forward ? e.low : e.high);
    }
    findings.branching_edges += edge.size() > 2;
  });
  double area = 0, caps = 0, open = 0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const double here = area_vector(surface, surface.triangles[t]).norm();
    area += here;
    if (patches[patch_of[t]].open) open += here;
  }
  while (!next.empty()) {
    auto at = next.begin();
    const Point origin = surface.vertices[static_cast<std::size_t>(at->first)];
    Point cap = Point::Zero();
    while (at != next.end()) {
      const VertexId to = at->second;
      cap += 0.5 * (surface.vertices[static_cast<std::size_t>(at->first)] - origin)
                       .cross(surface.vertices[static_cast<std::size_t>(to)] - origin);
      next.erase(at);
      at = next.find(to);
    }
    ++findings.holes;
    caps += cap.norm();
  }
  findings.hole_share = area > 0 ? caps / area : 0.0;
  findings.open_share = area > 0 ? open / area : 0.0;
}

struct Votes {
  int front = 0, back = 0;  // rays that reach infinity
};

// A side from which rays escape is outside.
Votes vote(const SurfaceMesh& surface, const TriangleTree& tree, const Patch& patch,
           std::size_t samples, std::mt19937_64& random) {
  std::vector<double> areas;
  for (const std::size_t t : patch.triangles)
    areas.push_back(area_vector(surface, surface.triangles[t]).norm());
  std::discrete_distribution<std::size_t> pick(areas.begin(), areas.end());
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> normal;
  Votes votes;
  for (std::size_t s = 0; s < samples; ++s) {
    const std::size_t t = patch.triangles[pick(random)];
    double u = uniform(random), v = uniform(random);
    if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
    const auto corner = [&](std::size_t i) -> const Point& {
      return surface.vertices[static_cast<std::size_t>(surface.triangles[t][i])];
    };
    const Point x = corner(0) + u * (corner(1) - corner(0)) + v * (corner(2) - corner(0));
    const Point up = area_vector(surface, surface.triangles[t]).normalized();
    for (int ray = 0; ray < kRays; ++ray) {
      Point direction = Point(normal(random), normal(random), normal(random)).normalized();
      if (direction.dot(up) < 0) direction = -direction;
      // Off the surface: another triangle may lie in the same plane.
      votes.front += std::isinf(tree.first_hit(x + kOff * direction, direction, t).distance);
      votes.back += std::isinf(tree.first_hit(x - kOff * direction, -direction, t).distance);
    }
  }
  return votes;
}

void turn(SurfaceMesh& surface, const Patch& patch, SurfaceFindings& findings) {
  for (const std::size_t t : patch.triangles)
    std::swap(surface.triangles[t][1], surface.triangles[t][2]);
  findings.turned += patch.triangles.size();
}

// Patches with an edge where others end have no inside of their own: what sees infinity decides.
void orient_open_patches(SurfaceMesh& surface, const std::vector<Patch>& patches,
                         SurfaceFindings& findings) {
  const TriangleTree tree(surface);
  std::mt19937_64 random(1);
  const std::size_t samples =
      std::clamp(kSamples / std::max<std::size_t>(1, patches.size()), kLeastSamples, kMostSamples);
  for (const Patch& patch : patches) {
    if (!patch.open && !patch.branching) continue;
    const Votes votes = vote(surface, tree, patch, samples, random);
    // A sheet that sees as much in front as behind stays as it is.
    if (votes.back > 2 * votes.front) turn(surface, patch, findings);
  }
}

struct Shell {
  std::size_t patch;
  BoundingBox box;
  double volume = 0;  // m^3, unsigned
  int depth = 0;      // how many others it lies in
};

bool contains(const BoundingBox& outer, const BoundingBox& inner) {
  return (outer.low.array() <= inner.low.array()).all() &&
         (outer.high.array() >= inner.high.array()).all();
}

SurfaceMesh part_of(const SurfaceMesh& surface, const Patch& patch) {
  SurfaceMesh part;
  part.vertices = surface.vertices;
  for (const std::size_t t : patch.triangles) part.triangles.push_back(surface.triangles[t]);
  return part;
}

// Closed shells: outermost ones face outwards. One inside another is a cavity if it faces the other
// way than the one around it did in the file, and superfluous if it faces the same way.
void settle_closed_shells(SurfaceMesh& surface, const std::vector<Patch>& patches,
                          SurfaceFindings& findings, std::vector<bool>& dropped) {
  std::vector<Shell> shells;
  std::vector<bool> inverted(patches.size(), false);
  for (std::size_t p = 0; p < patches.size(); ++p) {
    if (patches[p].open || patches[p].branching) continue;
    double volume = 0;
    std::vector<Point> corners;
    for (const std::size_t t : patches[p].triangles) {
      volume += volume_below(surface, surface.triangles[t]) / 6.0;
      for (const VertexId v : surface.triangles[t])
        corners.push_back(surface.vertices[static_cast<std::size_t>(v)]);
    }
    inverted[p] = volume < 0;
    shells.push_back({p, bounding_box(corners), std::abs(volume)});
  }
  std::sort(shells.begin(), shells.end(),
            [](const Shell& a, const Shell& b) { return a.volume > b.volume; });
  std::vector<std::size_t> parent(shells.size());
  for (std::size_t outer = 0; outer < shells.size(); ++outer) {
    std::unique_ptr<WindingNumber> winding;
    for (std::size_t inner = outer + 1; inner < shells.size(); ++inner) {
      if (!contains(shells[outer].box, shells[inner].box)) continue;
      if (!winding)
        winding = std::make_unique<WindingNumber>(part_of(surface, patches[shells[outer].patch]));
      const Triangle& t = surface.triangles[patches[shells[inner].patch].triangles.front()];
      if (std::abs(winding->at(surface.vertices[static_cast<std::size_t>(t[0])])) > 0.5) {
        ++shells[inner].depth;
        parent[inner] = outer;  // the smallest one around comes last
      }
    }
  }
  std::vector<bool> as_cavity(shells.size(), false);
  for (std::size_t s = 0; s < shells.size(); ++s) {
    const std::size_t p = shells[s].patch;
    const bool inside = shells[s].depth > 0;
    if (inside && dropped[shells[parent[s]].patch]) {
      dropped[p] = true;  // what lies in a superfluous shell
    } else if (inside && inverted[p] == inverted[shells[parent[s]].patch]) {
      dropped[p] = !as_cavity[parent[s]];
    } else {
      as_cavity[s] = inside && !as_cavity[parent[s]];
    }
    if (dropped[p]) {
      ++findings.inner_shells;
      continue;
    }
    findings.cavities += as_cavity[s];
    if (inverted[p] != as_cavity[s]) turn(surface, patches[p], findings);
  }
}

// Closed shells that only cross each other become one surface, of one patch.
bool unite(SurfaceMesh& surface, const std::vector<Patch>& patches,
           std::vector<std::size_t>& patch_of, SurfaceFindings& findings) {
  SurfaceMesh outwards = surface;
  SurfaceFindings turned = findings;
  std::size_t inwards = 0;
  for (const Patch& patch : patches) {
    double volume = 0;
    for (const std::size_t t : patch.triangles)
      volume += volume_below(surface, surface.triangles[t]);
    inwards += volume < 0;
    if (volume < 0) turn(outwards, patch, turned);
  }
  // Some of each: cavities, perhaps.
  if (inwards > 0 && inwards < patches.size()) return false;
  std::optional<SurfaceMesh> united = unite_shells(outwards, patch_of);
  if (!united) return false;
  findings.turned = turned.turned;
  findings.united = patches.size();
  findings.crossings = 0;
  surface = std::move(*united);
  patch_of.assign(surface.triangles.size(), 0);
  return true;
}

}  // namespace

RepairedSurface repair_surface(const SurfaceMesh& given) {
  RepairedSurface result;
  SurfaceFindings& findings = result.findings;
  SurfaceMesh surface = given;
  findings.triangles = surface.triangles.size();
  const WeldCounts counts = weld(surface);
  findings.welded = counts.welded;
  findings.degenerate = counts.degenerate;
  findings.repeated = counts.repeated;
  findings.cancelled = counts.cancelled;
  if (surface.triangles.empty()) return result;

  std::vector<std::size_t> patch_of;
  std::vector<Patch> patches = orient_within_patches(surface, patch_of, findings);
  find_holes(surface, patch_of, patches, findings);
  findings.shells = patches.size();
  if (findings.branching_edges == 0 && findings.one_sided_edges == 0)
    findings.crossings = count_crossings(surface);
  std::vector<bool> dropped(patches.size(), false);
  if (findings.crossings == 0)
    settle_closed_shells(surface, patches, findings, dropped);
  else if (findings.holes == 0 && unite(surface, patches, patch_of, findings))
    dropped.assign(1, false);
  if (!findings.clean()) {
    for (Patch& patch : patches) patch.branching = patch.branching || findings.crossings > 0;
    orient_open_patches(surface, patches, findings);
  }
  result.mesh.vertices = surface.vertices;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    if (dropped[patch_of[t]]) continue;
    result.mesh.triangles.push_back(surface.triangles[t]);
    result.shell_of.push_back(patch_of[t]);
  }
  drop_unused_vertices(result.mesh);
  return result;
}

std::vector<std::string> describe(const SurfaceFindings& f) {
  std::vector<std::string> lines;
  const auto say = [&](std::size_t count, const char* one, const char* many) {
    if (count > 0) lines.push_back(std::to_string(count) + (count == 1 ? one : many));
  };
  say(f.welded, " vertex welded to another at its place",
      " vertices welded to others at their place");
  say(f.degenerate, " triangle without an area left out", " triangles without an area left out");
  say(f.repeated, " repeated triangle left out", " repeated triangles left out");
  say(f.cancelled, "", " triangles that lay back to back in pairs left out: an inner wall");
  say(f.turned, " triangle turned to face outwards", " triangles turned to face outwards");
  say(f.united, "", " shells that overlapped united");
  say(f.inner_shells, " inner shell left out (it faces the same way as the one around it)",
      " inner shells left out (they face the same way as those around them)");
  say(f.cavities, " cavity kept", " cavities kept");
  if (f.holes > 0) {
    char text[160];
    std::snprintf(text, sizeof(text), "%zu hole%s, %.2g %% of the surface: closed by solid angle",
                  f.holes, f.holes == 1 ? "" : "s", 100.0 * f.hole_share);
    lines.emplace_back(text);
  }
  say(f.branching_edges, " edge where three or more triangles meet",
      " edges where three or more triangles meet");
  say(f.one_sided_edges, " edge across which no side is the outside",
      " edges across which no side is the outside");
  say(f.crossings, " pair of triangles that cross each other",
      " pairs of triangles that cross each other");
  return lines;
}

}  // namespace tremolo
