#include "precompute/mesher/surface/surface_solid.h"

#include <algorithm>
#include <random>

#include "precompute/mesher/surface/surface_geometry.h"

namespace tremolo {
namespace {

using Point = Eigen::Vector3d;

constexpr std::size_t kVolumeSamples = 40'000;

}  // namespace

SurfaceMesh scale(const RenderSurface& given, Scaling& scaling) {
  std::vector<Point> used;
  for (const Triangle& t : given.triangles)
    for (const VertexId v : t) used.push_back(given.vertices[v]);
  const BoundingBox box = bounding_box(used);
  scaling.centre = 0.5 * (box.low + box.high);
  scaling.diagonal = box.diagonal();
  SurfaceMesh surface;
  if (!(scaling.diagonal > 0)) return surface;
  surface.triangles = given.triangles;
  for (const Point& x : given.vertices) surface.vertices.push_back(scaling.in(x));
  return surface;
}

SurfaceSolid::SurfaceSolid(RepairedSurface repaired, double thickness)
    : surface(std::move(repaired.mesh)),
      shell_of(std::move(repaired.shell_of)),
      tree(surface),
      winding(surface),
      half_thickness(0.5 * thickness),
      closed(repaired.findings.clean()) {}

bool SurfaceSolid::inside(const Point& x) const {
  if (half_thickness > 0) return tree.nearest(x).distance < half_thickness;
  return winding.at(x) > 0.5;
}

Openness openness(const SurfaceSolid& solid) {
  constexpr std::size_t kPoints = 2'000;
  constexpr double kStep = 1e-5;
  Openness result;
  for (const SurfacePoint& at : spread_points(solid.surface, kPoints)) {
    const double behind = solid.winding.at(at.point - kStep * at.normal);
    result.backed += behind > 0.5;
    result.lacking += std::clamp(1.0 - behind, 0.0, 1.0);
  }
  result.backed /= kPoints;
  result.lacking /= kPoints;
  return result;
}

double volume(const SurfaceSolid& solid) {
  if (solid.closed && solid.half_thickness == 0) {
    double sum = 0;
    for (const Triangle& t : solid.surface.triangles) sum += volume_below(solid.surface, t);
    return sum;
  }
  const BoundingBox box = bounding_box(solid.surface.vertices);
  const Point low = box.low.array() - solid.half_thickness;
  const Point high = box.high.array() + solid.half_thickness;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::size_t hits = 0;
  for (std::size_t i = 0; i < kVolumeSamples; ++i) {
    const Point share(uniform(random), uniform(random), uniform(random));
    hits += solid.inside(low + share.cwiseProduct(high - low));
  }
  return (high - low).prod() * static_cast<double>(hits) / kVolumeSamples;
}

}  // namespace tremolo
