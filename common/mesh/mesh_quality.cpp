#include "common/mesh/mesh_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include "common/mesh/mesh_check.h"

namespace tremolo {
namespace {

using Corners = std::array<Eigen::Vector3d, 4>;

Corners corners_of(const TetMesh& mesh, const Tetrahedron& tet) {
  return {mesh.vertices[tet[0]], mesh.vertices[tet[1]], mesh.vertices[tet[2]],
          mesh.vertices[tet[3]]};
}

// Angle at edge a-b between the half planes towards c and d, degrees.
double dihedral(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                const Eigen::Vector3d& d) {
  const Eigen::Vector3d edge = b - a;
  const Eigen::Vector3d first = edge.cross(c - a);
  const Eigen::Vector3d second = edge.cross(d - a);
  // atan2 keeps its digits where arccos loses them: near 0 and 180 degrees.
  return std::atan2(first.cross(second).norm(), first.dot(second)) * 180.0 / std::numbers::pi;
}

void widen_dihedrals(const Corners& x, MeshQuality& quality) {
  constexpr std::array<std::array<int, 4>, 6> kEdges = {
      {{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 3, 1, 2}, {1, 2, 0, 3}, {1, 3, 0, 2}, {2, 3, 0, 1}}};
  for (const auto& [a, b, c, d] : kEdges) {
    const double angle = dihedral(x[a], x[b], x[c], x[d]);
    quality.min_dihedral_deg = std::min(quality.min_dihedral_deg, angle);
    quality.max_dihedral_deg = std::max(quality.max_dihedral_deg, angle);
  }
}

// With edges a, b, c from a corner and D = |a . (b x c)| = 6 V: the inscribed radius is 3 V / area,
// the circumscribed one |a^2 (b x c) + b^2 (c x a) + c^2 (a x b)| / (2 D).
double radius_ratio(const Corners& x) {
  const Eigen::Vector3d a = x[1] - x[0];
  const Eigen::Vector3d b = x[2] - x[0];
  const Eigen::Vector3d c = x[3] - x[0];
  const double determinant = std::abs(a.dot(b.cross(c)));
  const double area = 0.5 * (a.cross(b).norm() + b.cross(c).norm() + c.cross(a).norm() +
                             (b - a).cross(c - a).norm());
  const double numerator =
      (a.squaredNorm() * b.cross(c) + b.squaredNorm() * c.cross(a) + c.squaredNorm() * a.cross(b))
          .norm();
  if (determinant == 0.0 || numerator == 0.0) return 0.0;
  const double inscribed = 0.5 * determinant / area;
  const double circumscribed = 0.5 * numerator / determinant;
  return 3.0 * inscribed / circumscribed;
}

}  // namespace

MeshQuality mesh_quality(const TetMesh& mesh) {
  MeshQuality quality;
  if (mesh.tetrahedra.empty()) return quality;
  quality.min_dihedral_deg = 180.0;
  quality.min_radius_ratio = 1.0;
  quality.min_volume = std::numeric_limits<double>::infinity();
  double sum = 0.0;
  for (const Tetrahedron& tet : mesh.tetrahedra) {
    const Corners corners = corners_of(mesh, tet);
    widen_dihedrals(corners, quality);
    const double ratio = radius_ratio(corners);
    quality.min_radius_ratio = std::min(quality.min_radius_ratio, ratio);
    sum += ratio;
    const double volume = signed_volume(mesh, tet);
    quality.volume += volume;
    quality.min_volume = std::min(quality.min_volume, volume);
  }
  quality.mean_radius_ratio = sum / static_cast<double>(mesh.tetrahedra.size());
  quality.parts = mesh_parts(mesh).count;
  return quality;
}

}  // namespace tremolo
