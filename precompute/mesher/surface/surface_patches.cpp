#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <random>
#include <span>

#include "precompute/mesher/surface/repair_steps.h"
#include "precompute/mesher/surface/surface_geometry.h"

namespace tremolo {
namespace {

using Point = Eigen::Vector3d;

// Samples over all patches from which rays find the outside, and the most and least of one patch.
constexpr std::size_t kSamples = 40'000;
constexpr std::size_t kMostSamples = 64;
constexpr std::size_t kLeastSamples = 2;
constexpr int kRays = 4;       // on each side of a sample
constexpr double kOff = 1e-6;  // of their origins from the surface

double area(const SurfaceMesh& surface, std::size_t triangle) {
  return 0.5 * doubled_area(surface, surface.triangles[triangle]).norm();
}

struct Votes {
  int front = 0, back = 0;  // rays that reach infinity
};

// Counts the rays that escape from either side; the outside is where they do.
Votes vote(const SurfaceMesh& surface, const TriangleTree& tree, const SurfacePatch& patch,
           std::size_t samples, std::mt19937_64& random) {
  std::vector<double> areas;
  for (const std::size_t t : patch.triangles) areas.push_back(area(surface, t));
  std::discrete_distribution<std::size_t> pick(areas.begin(), areas.end());
  std::normal_distribution<double> normal;
  Votes votes;
  for (std::size_t s = 0; s < samples; ++s) {
    const std::size_t t = patch.triangles[pick(random)];
    const Point x = random_point(surface, surface.triangles[t], random);
    const Point up = doubled_area(surface, surface.triangles[t]).normalized();
    for (int ray = 0; ray < kRays; ++ray) {
      Point direction = Point(normal(random), normal(random), normal(random)).normalized();
      if (direction.dot(up) < 0) direction = -direction;
      // Rays start at a distance from the surface, since another triangle may be in the same plane.
      votes.front += std::isinf(tree.first_hit(x + kOff * direction, direction, t).distance);
      votes.back += std::isinf(tree.first_hit(x - kOff * direction, -direction, t).distance);
    }
  }
  return votes;
}

}  // namespace

std::vector<SurfaceEdge> sorted_edges(const std::vector<Triangle>& triangles) {
  std::vector<SurfaceEdge> edges;
  edges.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      const VertexId a = triangles[t][i], b = triangles[t][(i + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), t, a < b});
    }
  std::sort(edges.begin(), edges.end());
  return edges;
}

double signed_volume(const SurfaceMesh& surface, const SurfacePatch& patch) {
  double volume = 0;
  for (const std::size_t t : patch.triangles) volume += volume_below(surface, surface.triangles[t]);
  return volume;
}

void turn_patch(SurfaceMesh& surface, const SurfacePatch& patch) {
  for (const std::size_t t : patch.triangles)
    std::swap(surface.triangles[t][1], surface.triangles[t][2]);
}

std::vector<SurfacePatch> orient_within_patches(SurfaceMesh& surface,
                                                std::vector<std::size_t>& patch_of,
                                                SurfaceFindings& findings) {
  struct Link {
    std::size_t other;
    bool agrees;
  };
  const std::size_t count = surface.triangles.size();
  std::vector<std::vector<Link>> links(count);
  for_each_edge(sorted_edges(surface.triangles), [&](std::span<const SurfaceEdge> edge) {
    if (edge.size() != 2) return;
    const bool agrees = edge[0].forward != edge[1].forward;
    links[edge[0].triangle].push_back({edge[1].triangle, agrees});
    links[edge[1].triangle].push_back({edge[0].triangle, agrees});
  });
  constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  patch_of.assign(count, kNone);
  std::vector<bool> turned(count, false);
  std::vector<SurfacePatch> patches;
  std::size_t conflicts = 0;
  for (std::size_t seed = 0; seed < count; ++seed) {
    if (patch_of[seed] != kNone) continue;
    SurfacePatch patch;
    patch_of[seed] = patches.size();
    std::queue<std::size_t> front({seed});
    double turned_area = 0, whole = 0;
    while (!front.empty()) {
      const std::size_t t = front.front();
      front.pop();
      patch.triangles.push_back(t);
      const double here = area(surface, t);
      whole += here;
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
    const bool turn_rest = turned_area > 0.5 * whole;
    for (const std::size_t t : patch.triangles)
      if (turned[t] != turn_rest) std::swap(surface.triangles[t][1], surface.triangles[t][2]);
    patches.push_back(std::move(patch));
  }
  findings.one_sided_edges = conflicts / 2;
  return patches;
}

void find_holes(const SurfaceMesh& surface, const std::vector<std::size_t>& patch_of,
                std::vector<SurfacePatch>& patches, SurfaceFindings& findings) {
  std::multimap<VertexId, VertexId> next;
  for_each_edge(sorted_edges(surface.triangles), [&](std::span<const SurfaceEdge> edge) {
    for (const SurfaceEdge& e : edge) {
      SurfacePatch& patch = patches[patch_of[e.triangle]];
      patch.open = patch.open || edge.size() == 1;
      patch.branching = patch.branching || edge.size() > 2;
    }
    if (edge.size() == 1) {
      const SurfaceEdge& e = edge.front();
      next.emplace(e.forward ? e.high : e.low, e.forward ? e.low : e.high);
    }
    findings.branching_edges += edge.size() > 2;
  });
  double whole = 0, caps = 0, open = 0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const double here = area(surface, t);
    whole += here;
    if (patches[patch_of[t]].open) open += here;
  }
  while (!next.empty()) {
    auto at = next.begin();
    const Point origin = surface.vertices[at->first];
    Point cap = Point::Zero();
    while (at != next.end()) {
      const VertexId to = at->second;
      cap += 0.5 * (surface.vertices[at->first] - origin).cross(surface.vertices[to] - origin);
      next.erase(at);
      at = next.find(to);
    }
    ++findings.holes;
    caps += cap.norm();
  }
  findings.hole_share = whole > 0 ? caps / whole : 0.0;
  findings.open_share = whole > 0 ? open / whole : 0.0;
}

void orient_open_patches(SurfaceMesh& surface, const std::vector<SurfacePatch>& patches) {
  const TriangleTree tree(surface);
  std::mt19937_64 random(1);
  const std::size_t samples =
      std::clamp(kSamples / std::max<std::size_t>(1, patches.size()), kLeastSamples, kMostSamples);
  for (const SurfacePatch& patch : patches) {
    if (!patch.open && !patch.branching) continue;
    const Votes votes = vote(surface, tree, patch, samples, random);
    // A sheet that is equally open in front and behind keeps its orientation.
    if (votes.back > 2 * votes.front) turn_patch(surface, patch);
  }
}

}  // namespace tremolo
