#include "tests/lab/tets/shapes.h"

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include <Eigen/LU>

#include "common/mesh/surface_mesh.h"
#include "tests/support/meshes/box_mesh.h"

namespace tremolo::tets {
namespace {

constexpr double kBarLength = 0.4, kBarWidth = 0.1;                             // m
constexpr double kStem = 0.3, kCap = 0.1, kStemWidth = 0.05, kCapWidth = 0.15;  // m
constexpr double kTurns = 3.0, kRadius = 0.06, kRise = 0.05, kWire = 0.02;      // m

void add_point(const Eigen::Vector3d& place, std::size_t tet, const Eigen::Vector4d& weights,
               TetsSurface& points) {
  points.vertices.push_back(place);
  points.tetrahedra.push_back(static_cast<std::uint32_t>(tet));
  points.weights.push_back(weights);
}

// The points of the bar, each in the tetrahedron that it lies deepest in.
TetsSurface bar_points(const TetMesh& mesh) {
  std::vector<Eigen::Matrix4d> inverses;
  for (const Tetrahedron& tet : mesh.tetrahedra) {
    Eigen::Matrix4d corners;
    for (int c = 0; c < 4; ++c) corners.col(c) << mesh.vertices[tet[c]], 1.0;
    inverses.push_back(corners.inverse());
  }
  TetsSurface points;
  for (int n = 0; n < 17 * 9; ++n) {
    const Eigen::Vector3d x(kBarLength * (n / 9) / 16, kBarWidth * (n / 3 % 3) / 2,
                            kBarWidth * (n % 3) / 2);
    double best = -1e9;
    std::size_t found = 0;
    for (std::size_t t = 0; t < inverses.size(); ++t) {
      const double least = (inverses[t] * x.homogeneous()).minCoeff();
      if (least <= best) continue;
      best = least;
      found = t;
    }
    add_point(x, found, inverses[found] * x.homogeneous(), points);
  }
  return points;
}

// The vertices and the middles of the boundary's edges.
TetsSurface boundary_places(const TetMesh& mesh) {
  const BoundarySurface boundary = boundary_surface(mesh);
  std::set<std::pair<VertexId, VertexId>> wanted;
  for (const VertexId v : boundary.vertex_ids) wanted.emplace(v, v);
  for (const Triangle& t : boundary.triangles)
    for (std::size_t c = 0; c < 3; ++c) {
      const VertexId a = boundary.vertex_ids[t[c]];
      const VertexId b = boundary.vertex_ids[t[(c + 1) % 3]];
      wanted.emplace(std::min(a, b), std::max(a, b));
    }
  TetsSurface points;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j <= i; ++j) {
        const VertexId a = mesh.tetrahedra[t][i], b = mesh.tetrahedra[t][j];
        if (wanted.erase({std::min(a, b), std::max(a, b)}) == 0) continue;
        Eigen::Vector4d weights = Eigen::Vector4d::Zero();
        weights[i] += 0.5;
        weights[j] += 0.5;
        add_point(0.5 * (mesh.vertices[a] + mesh.vertices[b]), t, weights, points);
      }
  return points;
}

// Stem and cap are cut out of a box of cells.
TetMesh mushroom_mesh(int cells) {
  const int across = 3 * cells;
  const TetMesh box =
      testing::box_mesh({8 * cells, across, across}, {kStem + kCap, kCapWidth, kCapWidth});
  TetMesh mesh;
  std::map<VertexId, VertexId> numbers;
  for (Tetrahedron tet : box.tetrahedra) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const VertexId v : tet) middle += 0.25 * box.vertices[v];
    const Eigen::Vector3d off = middle - Eigen::Vector3d(0.0, 0.5 * kCapWidth, 0.5 * kCapWidth);
    const bool of_stem = std::max(std::abs(off.y()), std::abs(off.z())) < 0.5 * kStemWidth;
    if (!of_stem && middle.x() < kStem) continue;
    for (VertexId& v : tet) {
      const auto [at, fresh] = numbers.try_emplace(v, static_cast<VertexId>(mesh.vertices.size()));
      if (fresh) mesh.vertices.push_back(box.vertices[v]);
      v = at->second;
    }
    mesh.tetrahedra.push_back(tet);
  }
  return mesh;
}

// A box along x, wound: its x is the angle, y points away from the axis, z along the wire's other
// side.
TetMesh coil_mesh(int cells) {
  TetMesh mesh = testing::box_mesh({48 * cells, cells, cells}, {kTurns, kWire, kWire});
  const double around = 2.0 * std::numbers::pi * kRadius;
  const double length = std::hypot(around, kRise);
  for (Eigen::Vector3d& x : mesh.vertices) {
    const double angle = 2.0 * std::numbers::pi * x.x();
    const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0.0);
    const Eigen::Vector3d along(-std::sin(angle), std::cos(angle), 0.0);
    const Eigen::Vector3d tangent = (around * along - kRise * Eigen::Vector3d::UnitZ()) / length;
    const Eigen::Vector3d side = tangent.cross(out);
    x = Eigen::Vector3d(0.0, 0.0, -kRise * x.x()) + (kRadius + x.y() - 0.5 * kWire) * out +
        (x.z() - 0.5 * kWire) * side;
  }
  return mesh;
}

}  // namespace

const char* shape_name(ShapeKind kind) {
  if (kind == ShapeKind::kBar) return "bar";
  return kind == ShapeKind::kMushroom ? "mushroom" : "coil";
}

Shape make_shape(ShapeKind kind, int cells) {
  Shape shape;
  if (kind == ShapeKind::kBar) {
    shape.mesh = testing::box_mesh({4 * cells, cells, cells}, {kBarLength, kBarWidth, kBarWidth});
    shape.held = testing::vertices_on_plane(shape.mesh, 0, 0.0);
    shape.size = kBarLength;
    shape.points = bar_points(shape.mesh);
    return shape;
  }
  if (kind == ShapeKind::kMushroom) {
    shape.mesh = mushroom_mesh(cells);
    shape.held = testing::vertices_on_plane(shape.mesh, 0, 0.0);
    shape.size = kStem + kCap;
  } else {
    shape.mesh = coil_mesh(cells);
    // The first cross-section, as box_mesh() numbers it.
    for (int n = 0; n < (cells + 1) * (cells + 1); ++n) shape.held.push_back(n * (48 * cells + 1));
    shape.size = kTurns * kRise;
  }
  shape.points = boundary_places(shape.mesh);
  return shape;
}

}  // namespace tremolo::tets
