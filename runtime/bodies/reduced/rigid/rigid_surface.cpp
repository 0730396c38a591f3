// Surfaces of shapes as triangles, and the test that a surface is closed.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>

#include "common/text.h"
#include "runtime/bodies/reduced/rigid/rigid_solid.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

// A ring of vertices of a surface of revolution about z.
struct Ring {
  double radius = 0.0, height = 0.0;  // m
  int around = 0;                     // number of vertices
  // Angle of the first vertex, in steps between two vertices, from -1/2 to 1/2.
  double phase = 0.0;
};

// The triangles between two rings whose vertices begin at these numbers. An edge joins the vertices
// of both rings that are nearest to the same angle, so that the triangles have the rings' symmetry.
void stitch(const Ring& below, VertexId low, const Ring& above, VertexId high,
            std::vector<Triangle>& triangles) {
  // Vertex 0 is the one nearest to the angle 0; its phase is between -1/2 and 1/2.
  const auto turn_to_next = [](const Ring& ring, int k) {
    return (k + 0.5 + ring.phase) / ring.around;
  };
  for (int i = 0, j = 0; i < below.around || j < above.around;) {
    const VertexId a = low + i % below.around, b = high + j % above.around;
    const bool up =
        j < above.around && (i == below.around || turn_to_next(above, j) <= turn_to_next(below, i));
    if (up)
      triangles.push_back({a, high + (j + 1) % above.around, b});
    else
      triangles.push_back({a, low + (i + 1) % below.around, b});
    ++(up ? j : i);
  }
}

// A closed surface through the rings from the lower to the upper pole at these heights, m.
SurfaceMesh revolve(const std::vector<Ring>& rings, double lower, double upper) {
  SurfaceMesh mesh;
  std::vector<VertexId> first;
  for (const Ring& ring : rings) {
    first.push_back(static_cast<VertexId>(mesh.vertices.size()));
    for (int k = 0; k < ring.around; ++k) {
      const double angle = 2.0 * std::numbers::pi * (k + ring.phase) / ring.around;
      mesh.vertices.emplace_back(ring.radius * std::cos(angle), ring.radius * std::sin(angle),
                                 ring.height);
    }
  }
  const auto low = static_cast<VertexId>(mesh.vertices.size()), high = low + 1;
  mesh.vertices.emplace_back(0.0, 0.0, lower);
  mesh.vertices.emplace_back(0.0, 0.0, upper);
  const auto fan = [&](std::size_t ring, VertexId pole, bool up) {
    for (int k = 0; k < rings[ring].around; ++k) {
      const VertexId one = first[ring] + k, two = first[ring] + (k + 1) % rings[ring].around;
      mesh.triangles.push_back(up ? Triangle{pole, one, two} : Triangle{pole, two, one});
    }
  };
  fan(0, low, false);
  for (std::size_t k = 0; k + 1 < rings.size(); ++k)
    stitch(rings[k], first[k], rings[k + 1], first[k + 1], mesh.triangles);
  fan(rings.size() - 1, high, true);
  return mesh;
}

// Half circles of `count` rings each, about centres at -half_length and half_length.
SurfaceMesh rounded(double radius, double half_length, int points) {
  const int around = std::max(8, static_cast<int>(std::sqrt(2.0 * points)));
  const int half = std::max(2, around / 4);
  std::vector<Ring> rings;
  for (const double side : {-1.0, 1.0}) {
    // The equator of a sphere is one ring; of a capsule two.
    const int count = half_length == 0.0 && side > 0.0 ? half - 1 : half;
    for (int k = 0; k < count; ++k) {
      const double step = 0.5 * std::numbers::pi / half;
      const double up = side < 0.0 ? -step * (half - 1 - k) : step * (half - count + k);
      rings.push_back({radius * std::cos(up), side * half_length + radius * std::sin(up), around});
    }
  }
  return revolve(rings, -half_length - radius, half_length + radius);
}

// The rings of a cylinder whose vertices are that far from each other, m, except those of the rims.
// The vertices of the rings of the side are at angles of their own, so that it rolls well on
// obstacles between its rims. Half a turn about z or about x makes the same of the surface.
std::vector<Ring> drum_rings(double radius, double half_length, int around, double spacing) {
  const auto intervals = [spacing](double length) {
    return std::max(1, static_cast<int>(std::lround(length / spacing)));
  };
  const auto count = [&](double r) {
    return std::min(around, 2 * std::max(3, intervals(std::numbers::pi * r)));
  };
  const int outwards = intervals(radius), along = intervals(2.0 * half_length);
  std::vector<Ring> rings;
  for (int k = 1; k < outwards; ++k) {
    const double r = radius * k / outwards;
    rings.push_back({r, -half_length, count(r)});
  }
  rings.push_back({radius, -half_length, around});
  for (int k = 1; k < along; ++k) {
    const double height = 2.0 * k / along - 1.0;
    const double phase = 0.5 * along * height / std::numbers::phi;
    rings.push_back({radius, half_length * height, count(radius), phase - std::round(phase)});
  }
  rings.push_back({radius, half_length, around});
  for (int k = outwards - 1; k > 0; --k) {
    const double r = radius * k / outwards;
    rings.push_back({r, half_length, count(r)});
  }
  return rings;
}

// Half of the vertices are on the two rims, on which it rolls and stands. The others are
// spread evenly over its caps and its side.
SurfaceMesh drum(double radius, double half_length, int points) {
  const int around = std::max(12, 2 * (points / 8));
  const auto rings = [&](double spacing) {
    return drum_rings(radius, half_length, around, spacing);
  };
  const auto vertices = [&](double spacing) {
    int sum = 2;
    for (const Ring& ring : rings(spacing)) sum += ring.around;
    return sum;
  };
  double spacing = 2.0 * (radius + half_length);
  while (vertices(spacing / 1.02) <= points) spacing /= 1.02;
  return revolve(rings(spacing), -half_length, half_length);
}

// The numbers of cells along the edges: cells as near to cubes as `points` vertices allow.
std::array<int, 3> cells_of(const Vector3d& half, int points) {
  const auto cells = [&half](double size) {
    std::array<int, 3> n;
    for (int k = 0; k < 3; ++k)
      n[k] = std::max(1, static_cast<int>(std::lround(2.0 * half[k] / size)));
    return n;
  };
  const auto vertices = [](const std::array<int, 3>& n) {
    return 2.0 * (static_cast<double>(n[0]) * n[1] + static_cast<double>(n[1]) * n[2] +
                  static_cast<double>(n[2]) * n[0]) +
           2.0;
  };
  double size = 2.0 * half.minCoeff();
  while (vertices(cells(size)) > points && size < 4.0 * half.maxCoeff()) size *= 1.05;
  while (vertices(cells(size / 1.02)) <= points) size /= 1.02;
  return cells(size);
}

SurfaceMesh block(const Vector3d& half, int points) {
  const std::array<int, 3> n = cells_of(half, points);
  SurfaceMesh mesh;
  std::map<std::array<int, 3>, VertexId> known;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [found, fresh] = known.try_emplace(at, static_cast<VertexId>(mesh.vertices.size()));
    if (fresh)
      mesh.vertices.emplace_back(half.x() * (2.0 * at[0] / n[0] - 1.0),
                                 half.y() * (2.0 * at[1] / n[1] - 1.0),
                                 half.z() * (2.0 * at[2] / n[2] - 1.0));
    return found->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const bool far : {false, true}) {
      const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
      for (int i = 0; i < n[u]; ++i)
        for (int j = 0; j < n[v]; ++j) {
          const auto corner = [&](int a, int b) {
            std::array<int, 3> at;
            at[axis] = far ? n[axis] : 0;
            at[u] = i + a;
            at[v] = j + b;
            return vertex(at);
          };
          std::array<VertexId, 4> quad = {corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)};
          if (!far) std::swap(quad[1], quad[3]);
          mesh.triangles.push_back({quad[0], quad[1], quad[2]});
          mesh.triangles.push_back({quad[0], quad[2], quad[3]});
        }
    }
  return mesh;
}

}  // namespace

SurfaceMesh surface_of_shape(const Collider& shape, int points) {
  if (const auto* sphere = std::get_if<SphereShape>(&shape))
    return rounded(sphere->radius, 0.0, points);
  if (const auto* capsule = std::get_if<CapsuleShape>(&shape))
    return rounded(capsule->radius, capsule->half_length, points);
  if (const auto* cylinder = std::get_if<CylinderShape>(&shape))
    return drum(cylinder->radius, cylinder->half_length, points);
  if (const auto* box = std::get_if<BoxShape>(&shape)) return block(box->half_extents, points);
  return {};
}

Status check_closed(const SurfaceMesh& surface) {
  std::map<std::pair<VertexId, VertexId>, int> edges;
  for (const Triangle& triangle : surface.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++edges[{triangle[k], triangle[(k + 1) % 3]}];
  std::size_t open = 0;
  std::pair<VertexId, VertexId> first;
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge.second, edge.first});
    if (count == 1 && back != edges.end() && back->second == 1) continue;
    if (open++ == 0) first = edge;
  }
  if (open == 0) return Success{};
  return content_error("the surface is not closed: " + std::to_string(open) +
                       (open == 1 ? " edge is" : " edges are") +
                       " not shared by two triangles that face the same side, the first from "
                       "vertex " +
                       std::to_string(first.first) + " to vertex " + std::to_string(first.second) +
                       " (counted from 0); close it, or give each corner one vertex");
}

}  // namespace tremolo
