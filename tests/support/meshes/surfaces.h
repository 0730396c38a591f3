// Surfaces with a known inside, and ways to spoil them.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "common/mesh/render_surface.h"
#include "common/mesh/surface_mesh.h"

namespace tremolo::testing {

inline SurfaceMesh box_surface(const Eigen::Vector3d& size,
                               const Eigen::Vector3d& low = Eigen::Vector3d::Zero()) {
  SurfaceMesh surface;
  for (int i = 0; i < 8; ++i)
    surface.vertices.push_back(low + Eigen::Vector3d(i & 1, i >> 1 & 1, i >> 2).cwiseProduct(size));
  surface.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                       {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return surface;
}

// rows x columns quads about the z axis; row 0 starts `from` radians from the pole: above 0 there
// is a hole. No degenerate triangles.
inline SurfaceMesh sphere_surface(double radius, int rows = 24, int columns = 48, double from = 0) {
  SurfaceMesh surface;
  const auto at = [&](int i, int j) { return static_cast<VertexId>(i * columns + j % columns); };
  const double start = from > 0 ? from : std::numbers::pi / (rows + 1);
  const double end = std::numbers::pi - std::numbers::pi / (rows + 1);
  for (int i = 0; i <= rows; ++i)
    for (int j = 0; j < columns; ++j) {
      const double theta = start + (end - start) * i / rows;
      const double phi = 2.0 * std::numbers::pi * j / columns;
      surface.vertices.push_back(radius * Eigen::Vector3d(std::sin(theta) * std::cos(phi),
                                                          std::sin(theta) * std::sin(phi),
                                                          std::cos(theta)));
    }
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) {
      surface.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      surface.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  const auto south = static_cast<VertexId>(surface.vertices.size());
  surface.vertices.push_back({0, 0, -radius});
  for (int j = 0; j < columns; ++j)
    surface.triangles.push_back({at(rows, j), south, at(rows, j + 1)});
  if (from > 0) return surface;
  const auto north = static_cast<VertexId>(surface.vertices.size());
  surface.vertices.push_back({0, 0, radius});
  for (int j = 0; j < columns; ++j) surface.triangles.push_back({north, at(0, j), at(0, j + 1)});
  return surface;
}

inline SurfaceMesh torus_surface(double large, double small, int rings = 64, int sides = 24) {
  SurfaceMesh surface;
  const auto at = [&](int i, int j) {
    return static_cast<VertexId>(i % rings * sides + j % sides);
  };
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < sides; ++j) {
      const double a = 2.0 * std::numbers::pi * i / rings, b = 2.0 * std::numbers::pi * j / sides;
      const double reach = large + small * std::cos(b);
      surface.vertices.push_back({reach * std::cos(a), reach * std::sin(a), small * std::sin(b)});
    }
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < sides; ++j) {
      surface.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      surface.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return surface;
}

// A strip with `half_turns` half turns: odd ones have one side.
inline SurfaceMesh strip_surface(int half_turns, int steps = 60) {
  SurfaceMesh surface;
  for (int i = 0; i < steps; ++i) {
    const double a = 2.0 * std::numbers::pi * i / steps, twist = 0.5 * half_turns * a;
    for (const double side : {-0.3, 0.3}) {
      const double reach = 1.0 + side * std::cos(twist);
      surface.vertices.push_back(
          {reach * std::cos(a), reach * std::sin(a), side * std::sin(twist)});
    }
  }
  for (int i = 0; i < steps; ++i) {
    VertexId a = 2 * i, b = 2 * i + 1, c = 2 * (i + 1), d = 2 * (i + 1) + 1;
    if (i + 1 == steps) {
      c = half_turns % 2 == 1 ? 1 : 0;
      d = 1 - c;
    }
    surface.triangles.push_back({a, c, d});
    surface.triangles.push_back({a, d, b});
  }
  return surface;
}

inline SurfaceMesh plane_surface(int cells) {
  SurfaceMesh surface;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i)
      surface.vertices.push_back({1.0 * i / cells, 1.0 * j / cells, 0});
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const VertexId a = j * (cells + 1) + i, b = a + cells + 1;
      surface.triangles.push_back({a, a + 1, b + 1});
      surface.triangles.push_back({a, b + 1, b});
    }
  return surface;
}

inline SurfaceMesh together(SurfaceMesh a, const SurfaceMesh& b) {
  const auto shift = static_cast<VertexId>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const Triangle& t : b.triangles)
    a.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  return a;
}

inline SurfaceMesh reversed(SurfaceMesh surface) {
  for (Triangle& t : surface.triangles) std::swap(t[1], t[2]);
  return surface;
}

// Every triangle with corners of its own, as in an STL file.
inline SurfaceMesh soup(const SurfaceMesh& surface) {
  SurfaceMesh loose;
  for (const Triangle& t : surface.triangles) {
    const auto first = static_cast<VertexId>(loose.vertices.size());
    for (const VertexId v : t) loose.vertices.push_back(surface.vertices[v]);
    loose.triangles.push_back({first, first + 1, first + 2});
  }
  return loose;
}

inline SurfaceMesh turned_at_random(SurfaceMesh surface, double share) {
  std::mt19937_64 random(3);
  std::bernoulli_distribution turn(share);
  for (Triangle& t : surface.triangles)
    if (turn(random)) std::swap(t[1], t[2]);
  return surface;
}

inline double enclosed_volume(const SurfaceMesh& surface) {
  double sum = 0;
  for (const Triangle& t : surface.triangles)
    sum += surface.vertices[t[0]].dot(surface.vertices[t[1]].cross(surface.vertices[t[2]])) / 6.0;
  return sum;
}

inline RenderSurface as_render_surface(const SurfaceMesh& surface) {
  RenderSurface render;
  render.vertices = surface.vertices;
  render.triangles = surface.triangles;
  render.objects = {"body"};
  render.materials = {"plain"};
  render.object_of.assign(surface.triangles.size(), 0);
  render.material_of.assign(surface.triangles.size(), 0);
  return render;
}

}  // namespace tremolo::testing
