#include "common/mesh/refined_surface.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace tremolo {
namespace {

using Eigen::Vector3d;

// Length of the longest edge, m; `first` receives the number of the corner where it begins.
double longest_edge(const SurfaceMesh& mesh, const Triangle& triangle, std::size_t& first) {
  double longest = -1.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double length =
        (mesh.vertices[triangle[(k + 1) % 3]] - mesh.vertices[triangle[k]]).norm();
    if (!(length > longest)) continue;
    longest = length;
    first = k;
  }
  return longest;
}

// Divides at the middle of the longest edge, which the neighbour of that edge shares.
class Divider {
 public:
  explicit Divider(RefinedSurface& surface) : surface_(surface) {}

  void divide(const Triangle& triangle, double spacing) {
    std::vector<Triangle> waiting = {triangle};
    while (!waiting.empty()) {
      const Triangle next = waiting.back();
      waiting.pop_back();
      std::size_t k = 0;
      if (!(longest_edge(surface_.mesh, next, k) > spacing)) {
        surface_.mesh.triangles.push_back(next);
        continue;
      }
      const VertexId a = next[k], b = next[(k + 1) % 3], c = next[(k + 2) % 3], m = middle(a, b);
      waiting.push_back({m, b, c});
      waiting.push_back({a, m, c});
    }
  }

 private:
  VertexId middle(VertexId a, VertexId b) {
    std::vector<Vector3d>& vertices = surface_.mesh.vertices;
    const auto [found, fresh] =
        middles_.try_emplace(std::minmax(a, b), static_cast<VertexId>(vertices.size()));
    if (fresh) {
      vertices.push_back(0.5 * (vertices[a] + vertices[b]));
      surface_.origin.push_back(surface_.origin[std::min(a, b)]);
    }
    return found->second;
  }

  RefinedSurface& surface_;
  std::map<std::pair<VertexId, VertexId>, VertexId> middles_;
};

}  // namespace

RefinedSurface refine_surface(const SurfaceMesh& surface, double spacing, std::size_t most) {
  RefinedSurface refined;
  refined.mesh.vertices = surface.vertices;
  refined.origin.resize(surface.vertices.size());
  std::iota(refined.origin.begin(), refined.origin.end(), VertexId{0});
  std::vector<Triangle> large;
  double lengths = 0.0;  // half the sum of the longest edges of large triangles, m
  for (const Triangle& triangle : surface.triangles) {
    std::size_t first = 0;
    const double longest = longest_edge(surface, triangle, first);
    if (longest > 2.0 * spacing) {
      large.push_back(triangle);
      lengths += 0.5 * longest;
    } else {
      refined.mesh.triangles.push_back(triangle);
    }
  }
  Divider divider(refined);
  // A needle has (length/spacing)^log2(3) pieces.
  const double least = lengths / std::pow(static_cast<double>(most), 1.0 / std::log2(3.0));
  for (const Triangle& triangle : large) divider.divide(triangle, std::max(spacing, least));
  return refined;
}

}  // namespace tremolo
