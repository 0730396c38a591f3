#include "precompute/problem/wall_layers.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/format_text.h"
#include "common/mesh/tet_faces.h"

namespace tremolo {
namespace {

constexpr std::size_t kNone = static_cast<std::size_t>(-1);

// Side 4 t + f of each side's other tetrahedron; kNone on the boundary.
std::vector<std::size_t> find_neighbours(const TetMesh& mesh) {
  std::vector<std::size_t> across(4 * mesh.tetrahedra.size(), kNone);
  for_each_face(mesh, [&](std::span<const std::size_t> sides) {
    if (sides.size() != 2) return;
    across[sides[0]] = sides[1];
    across[sides[1]] = sides[0];
  });
  return across;
}

// Twice the area, outwards.
Eigen::Vector3d face_normal(const TetMesh& mesh, std::size_t side) {
  const Triangle face = tet_face(mesh.tetrahedra[side / 4], side % 4);
  const Eigen::Vector3d& a = mesh.vertices[face[0]];
  return (mesh.vertices[face[1]] - a).cross(mesh.vertices[face[2]] - a);
}

// A line through a wall. area: what it stands for, m^2.
struct Line {
  double thickness = 0;  // m
  double layers = 0;
  double edge = 0;  // m
  double area = 0;
};

// How far the tetrahedron reaches along a direction, and its longest edge across it.
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

// Straight in from a side on the boundary. No thickness where the line leaves the body at no wall:
// through a side that is not parallel.
Line follow(const TetMesh& mesh, const std::vector<std::size_t>& across, std::size_t start) {
  constexpr double kParallel = 0.8;      // cosine between the normals of a wall's two sides
  constexpr int kMostElements = 10'000;  // on a line, which rounding may send astray
  const Eigen::Vector3d normal = face_normal(mesh, start);
  const Eigen::Vector3d along = -normal.normalized();
  const Triangle face = tet_face(mesh.tetrahedra[start / 4], start % 4);
  // Off the middle, where lines of regular meshes would run along faces and edges.
  Eigen::Vector3d x =
      0.41 * mesh.vertices[face[0]] + 0.32 * mesh.vertices[face[1]] + 0.27 * mesh.vertices[face[2]];
  Line line;
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
    line.thickness += length;
    line.layers += length / extent;
    weighted_edge += length * edge;
    x += length * along;
    if (across[out] == kNone) {
      if (face_normal(mesh, out).normalized().dot(along) < kParallel) return {};
      line.edge = weighted_edge / line.thickness;
      line.area = 0.5 * normal.norm();
      return line;
    }
    side = across[out];
  }
  return {};
}

// The value that a share of the area lies below. Sorts the lines.
double quantile(std::vector<Line>& lines, double Line::*what, double share) {
  std::sort(lines.begin(), lines.end(),
            [what](const Line& a, const Line& b) { return a.*what < b.*what; });
  double all = 0, below = 0;
  for (const Line& line : lines) all += line.area;
  for (const Line& line : lines)
    if ((below += line.area) >= share * all) return line.*what;
  return lines.back().*what;
}

}  // namespace

std::optional<WallLayers> find_wall_layers(const TetMesh& mesh) {
  constexpr std::size_t kLines = 4'000;
  constexpr double kThinnest = 0.1;  // share of the area
  constexpr double kAsThin = 1.1;    // times their thickness still counts
  const std::vector<std::size_t> across = find_neighbours(mesh);
  std::vector<std::size_t> boundary;
  for (std::size_t side = 0; side < across.size(); ++side)
    if (across[side] == kNone) boundary.push_back(side);
  const std::size_t stride = std::max<std::size_t>(1, boundary.size() / kLines);
  std::vector<Line> lines;
  for (std::size_t i = 0; i < boundary.size(); i += stride)
    if (const Line line = follow(mesh, across, boundary[i]); line.thickness > 0)
      lines.push_back(line);
  if (lines.empty()) return std::nullopt;
  const double bound = kAsThin * quantile(lines, &Line::thickness, kThinnest);
  std::erase_if(lines, [bound](const Line& line) { return line.thickness > bound; });
  WallLayers walls;
  walls.thickness = quantile(lines, &Line::thickness, 0.5);
  walls.layers = quantile(lines, &Line::layers, 0.5);
  walls.edge = quantile(lines, &Line::edge, 0.5) / walls.thickness;
  return walls;
}

double frequency_excess(const WallLayers& walls, double poisson) {
  // lambda / E: without end for what cannot be compressed.
  const double bulk = std::max(0.0, poisson) / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
  // Of the energy: strain that is constant in an element, and volume that cannot change in each of
  // them. Fitted to bars and plates of one to six layers, in cells and from the mesher, nu 0 to
  // 0.499.
  const double excess = (1.25 + 0.53 * std::pow(bulk, 0.83)) * walls.edge * walls.edge;
  return std::sqrt(1.0 + excess) - 1.0;
}

Locking find_locking(const Problem& problem) {
  Locking locking;
  locking.walls = find_wall_layers(problem.mesh);
  for (const NamedMaterial& named : problem.materials.materials)
    if (!named.material.orthotropic)
      locking.poisson = std::max(locking.poisson.value_or(-1.0), named.material.poisson);
  if (locking.walls && locking.poisson)
    locking.excess = frequency_excess(*locking.walls, *locking.poisson);
  return locking;
}

std::vector<std::string> describe(const Locking& locking) {
  constexpr double kTold = 0.03;
  constexpr double kHardlyCompressed = 0.4;
  if (!locking.excess || *locking.excess < kTold) return {};
  return {text(
      "the thinnest walls, %.3g m, are %.2g layers of linear tetrahedra thick and nu is "
      "%.4g: frequencies of bending come out too high, by about %.2g %% (estimated, to a "
      "factor of two)%s; finer elements help",
      locking.walls->thickness, locking.walls->layers, *locking.poisson, 100.0 * *locking.excess,
      *locking.poisson > kHardlyCompressed ? ", as elements lock that can hardly be compressed"
                                           : "")};
}

nlohmann::ordered_json to_json(const Locking& locking) {
  using Json = nlohmann::ordered_json;
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
