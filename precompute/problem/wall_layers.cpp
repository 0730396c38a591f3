#include "precompute/problem/wall_layers.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/mesh/tet_faces.h"
#include "common/text.h"

namespace tremolo {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kNone = static_cast<std::size_t>(-1);

// For each side 4 t + f, returns the same face's side in the other tetrahedron; kNone on the
// boundary.
std::vector<std::size_t> find_neighbours(const TetMesh& mesh) {
  std::vector<std::size_t> across(4 * mesh.tetrahedra.size(), kNone);
  for_each_face(mesh, [&](std::span<const std::size_t> sides) {
    if (sides.size() != 2) return;
    across[sides[0]] = sides[1];
    across[sides[1]] = sides[0];
  });
  return across;
}

// Returns the outward normal with twice the face's area as its length.
Eigen::Vector3d face_normal(const TetMesh& mesh, std::size_t side) {
  const Triangle face = tet_face(mesh.tetrahedra[side / 4], side % 4);
  const Eigen::Vector3d& a = mesh.vertices[face[0]];
  return (mesh.vertices[face[1]] - a).cross(mesh.vertices[face[2]] - a);
}

// A ray through a wall. area: the share of the surface that it represents, m^2.
struct Ray {
  double thickness = 0;  // m
  double layers = 0;
  double edge = 0;  // m
  double area = 0;
};

// Computes the tetrahedron's extent along a direction and its longest edge perpendicular to it, m.
void measure(const TetMesh& mesh, const Tetrahedron& tet, const Eigen::Vector3d& along,
             double& extent, double& edge) {
  double low = std::numeric_limits<double>::max(), high = -low, longest = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d& x = mesh.vertices[tet[i]];
    low = std::min(low, x.dot(along));
    high = std::max(high, x.dot(along));
    for (std::size_t j = 0; j < i; ++j) {
      const Eigen::Vector3d e = mesh.vertices[tet[j]] - x;
      longest = std::max(longest, (e - e.dot(along) * along).norm());
    }
  }
  extent = high - low;
  edge = longest;
}

// Follows the inward normal of a boundary side. The thickness is 0 if the ray leaves through a side
// that is not parallel to the first, i.e. there is no wall.
Ray follow(const TetMesh& mesh, const std::vector<std::size_t>& across, std::size_t start) {
  constexpr double kParallel = 0.8;      // cosine between the normals of a wall's two sides
  constexpr int kMostElements = 10'000;  // on one ray, which rounding may lead astray
  const Eigen::Vector3d normal = face_normal(mesh, start);
  const Eigen::Vector3d along = -normal.normalized();
  const Triangle face = tet_face(mesh.tetrahedra[start / 4], start % 4);
  // Away from the centroid, where rays in regular meshes would run along faces and edges.
  Eigen::Vector3d x =
      0.41 * mesh.vertices[face[0]] + 0.32 * mesh.vertices[face[1]] + 0.27 * mesh.vertices[face[2]];
  Ray ray;
  double weighted_edge = 0;
  for (std::size_t side = start, steps = 0; steps < kMostElements; ++steps) {
    const std::size_t tet = side / 4;
    double length = std::numeric_limits<double>::max();
    std::size_t out = kNone;
    for (std::size_t other = 4 * tet; other < 4 * tet + 4; ++other) {
      if (other == side) continue;
      const Eigen::Vector3d outwards = face_normal(mesh, other);
      const double slope = outwards.dot(along);
      if (!(slope > 0)) continue;
      const VertexId corner = tet_face(mesh.tetrahedra[tet], other % 4)[0];
      const double distance = std::max(0.0, outwards.dot(mesh.vertices[corner] - x) / slope);
      if (distance < length) {
        length = distance;
        out = other;
      }
    }
    if (out == kNone) return {};
    double extent = 0, edge = 0;
    measure(mesh, mesh.tetrahedra[tet], along, extent, edge);
    ray.thickness += length;
    ray.layers += length / extent;
    weighted_edge += length * edge;
    x += length * along;
    if (across[out] == kNone) {
      if (face_normal(mesh, out).normalized().dot(along) < kParallel) return {};
      ray.edge = weighted_edge / ray.thickness;
      ray.area = 0.5 * normal.norm();
      return ray;
    }
    side = across[out];
  }
  return {};
}

// Returns the value below which a share of the area lies. Sorts the rays.
double quantile(std::vector<Ray>& rays, double Ray::*what, double share) {
  std::sort(rays.begin(), rays.end(),
            [what](const Ray& a, const Ray& b) { return a.*what < b.*what; });
  double all = 0, below = 0;
  for (const Ray& ray : rays) all += ray.area;
  for (const Ray& ray : rays)
    if ((below += ray.area) >= share * all) return ray.*what;
  return rays.back().*what;
}

}  // namespace

std::optional<WallLayers> find_wall_layers(const TetMesh& mesh) {
  constexpr std::size_t kRays = 4'000;
  constexpr double kThinnest = 0.1;  // share of the area that counts as thinnest
  constexpr double kAsThin = 1.1;    // walls up to this multiple of their thickness are included
  const std::vector<std::size_t> across = find_neighbours(mesh);
  std::vector<std::size_t> boundary;
  for (std::size_t side = 0; side < across.size(); ++side)
    if (across[side] == kNone) boundary.push_back(side);
  const std::size_t stride = std::max<std::size_t>(1, boundary.size() / kRays);
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < boundary.size(); i += stride)
    if (const Ray ray = follow(mesh, across, boundary[i]); ray.thickness > 0) rays.push_back(ray);
  if (rays.empty()) return std::nullopt;
  const double bound = kAsThin * quantile(rays, &Ray::thickness, kThinnest);
  std::erase_if(rays, [bound](const Ray& ray) { return ray.thickness > bound; });
  WallLayers walls;
  walls.thickness = quantile(rays, &Ray::thickness, 0.5);
  walls.layers = quantile(rays, &Ray::layers, 0.5);
  walls.edge = quantile(rays, &Ray::edge, 0.5) / walls.thickness;
  return walls;
}

double frequency_excess(const WallLayers& walls, double poisson) {
  // lambda / E; tends to infinity for incompressible materials.
  const double bulk = std::max(0.0, poisson) / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
  // Relative excess of the energy: one term for strain that is constant in an element, one for the
  // volume each element must keep. Fitted to bars and plates of one to six layers, on structured
  // grids and meshes from the mesher, nu 0 to 0.499.
  const double excess = (1.25 + 0.53 * std::pow(bulk, 0.83)) * walls.edge * walls.edge;
  return std::sqrt(1.0 + excess) - 1.0;
}

Locking find_locking(const Problem& problem) {
  Locking locking;
  locking.walls = find_wall_layers(problem.mesh);
  for (const NamedMaterial& named : problem.materials.materials)
    if (!named.material.orthotropic)
      locking.poisson = std::max(locking.poisson.value_or(-1.0), named.material.poisson);
  if (problem.order == 1 && locking.walls && locking.poisson)
    locking.excess = frequency_excess(*locking.walls, *locking.poisson);
  return locking;
}

std::vector<std::string> describe(const Locking& locking) {
  constexpr double kReportedExcess = 0.03, kWarnedExcess = 0.1;
  constexpr double kNearlyIncompressible = 0.4;
  if (!locking.excess || *locking.excess < kReportedExcess) return {};
  return {text(
      "%sthe thinnest walls, %.3g m, are %.2g layers of linear tetrahedra thick and nu is "
      "%.4g: frequencies of bending come out too high, by about %.2g %% (estimated, to a "
      "factor of two)%s; --order 2 helps, or finer elements",
      *locking.excess < kWarnedExcess ? "" : "warning: ", locking.walls->thickness,
      locking.walls->layers, *locking.poisson, 100.0 * *locking.excess,
      *locking.poisson > kNearlyIncompressible ? ", as elements lock that can hardly be compressed"
                                               : "")};
}

nlohmann::ordered_json to_json(const Locking& locking) {
  const auto wall = [&locking](double WallLayers::*what) {
    return locking.walls ? Json((*locking.walls).*what) : Json(nullptr);
  };
  const auto number = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json(nullptr);
  };
  return {{"wall_thickness_m", wall(&WallLayers::thickness)},
          {"layers", wall(&WallLayers::layers)},
          {"edge_over_thickness", wall(&WallLayers::edge)},
          {"poisson", number(locking.poisson)},
          {"frequency_excess", number(locking.excess)}};
}

}  // namespace tremolo
