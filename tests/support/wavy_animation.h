// A sheet of squares that waves: an animation with everything that a writer may meet.
#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "runtime/io/exchange/animation.h"

namespace tremolo::testing {

// n x n vertices, 1 m wide, with texture coordinates and two materials; `modes` smooth random
// fields of some centimetres.
inline AnimatedShape wavy_sheet(int n, Eigen::Index modes, unsigned seed = 3) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  AnimatedShape shape;
  shape.name = "sheet";
  RenderSurface& surface = shape.surface;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const double x = static_cast<double>(i) / (n - 1), y = static_cast<double>(j) / (n - 1);
      surface.vertices.emplace_back(x, y, 0.1 * x * y);
      surface.uvs.emplace_back(static_cast<float>(x), static_cast<float>(y));
    }
  for (int j = 0; j + 1 < n; ++j)
    for (int i = 0; i + 1 < n; ++i) {
      const VertexId a = j * n + i, b = a + 1, c = b + n, d = a + n;
      surface.triangles.push_back({a, b, c});
      surface.triangles.push_back({a, c, d});
      for (int k = 0; k < 2; ++k) surface.material_of.push_back(2 * i < n ? 0 : 1);
    }
  surface.object_of.assign(surface.triangles.size(), 0);
  surface.objects = {"sheet"};
  surface.materials = {"left", "right"};
  shape.modes.resize(3 * n * n, modes);
  for (Eigen::Index m = 0; m < modes; ++m) {
    const Eigen::Vector3d direction(uniform(generator), uniform(generator), uniform(generator));
    const double kx = 5.0 * uniform(generator), ky = 5.0 * uniform(generator);
    for (Eigen::Index v = 0; v < n * n; ++v) {
      const Eigen::Vector3d& x = surface.vertices[v];
      shape.modes.block<3, 1>(3 * v, m) = std::sin(kx * x.x() + ky * x.y() + 1.0) * direction;
    }
  }
  return shape;
}

// One body of it, its coordinates sines of an amplitude; it rotates about z, twice in all, and
// glides.
inline Animation wavy_animation(int n, Eigen::Index modes, std::size_t frames,
                                double amplitude = 0.02) {
  Animation animation;
  animation.shapes.push_back(wavy_sheet(n, modes));
  AnimatedBody body;
  body.name = "sheet";
  for (std::size_t f = 0; f < frames; ++f) {
    const double t = static_cast<double>(f) / 60.0;
    animation.times.push_back(t);
    for (Eigen::Index m = 0; m < modes; ++m)
      body.q.push_back(amplitude *
                       std::sin((2.0 + static_cast<double>(m)) * t + static_cast<double>(m)));
    const double angle = 4.0 * std::numbers::pi * static_cast<double>(f) /
                         static_cast<double>(std::max<std::size_t>(frames, 2) - 1);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
    // As a solver may hand it out: the sign says nothing.
    const Eigen::Vector4d coefficients = (f % 3 == 1 ? -1.0 : 1.0) * turn.coeffs();
    body.poses.push_back({Eigen::Vector3d(0.5 * t, 0.0, 1.0), Eigen::Quaterniond(coefficients)});
  }
  animation.bodies.push_back(std::move(body));
  return animation;
}

}  // namespace tremolo::testing
