// A render surface for sample_basis(): a tube's side, cut along a seam.
#pragma once

#include <cmath>

#include "tests/support/sample_basis.h"

namespace tremolo::testing {

inline constexpr int kTubeSides = 12;
inline constexpr int kTubeRings = 5;

// Rings of kTubeSides + 1 vertices: the last of a ring lies on its first with another texture
// coordinate, the same normal and the same rows. Two objects, below and above the middle ring;
// material 1 on the last column of quads. Vertices from the first `anchors` of the mesh.
inline RenderBlock tube(Eigen::Index r, unsigned seed = 11) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  RenderBlock render;
  RenderSurface& surface = render.surface;
  surface.objects = {"below", "above"};
  surface.materials = {"paint", "seam"};
  for (int ring = 0; ring < kTubeRings; ++ring)
    for (int side = 0; side <= kTubeSides; ++side) {
      const double angle = 2.0 * M_PI * (side % kTubeSides) / kTubeSides;
      const Eigen::Vector3d normal(std::cos(angle), std::sin(angle), 0.0);
      surface.vertices.push_back(normal + Eigen::Vector3d(0, 0, ring));
      surface.normals.push_back(normal.cast<float>());
      surface.uvs.emplace_back(static_cast<float>(side) / kTubeSides,
                               0.25f * static_cast<float>(ring));
      surface.colours.push_back({static_cast<std::uint8_t>(10 * side), 20, 30, 255});
      render.anchors.push_back(static_cast<VertexId>(render.anchors.size() % 7));
    }
  constexpr int kRow = kTubeSides + 1;
  for (int ring = 0; ring + 1 < kTubeRings; ++ring)
    for (int side = 0; side < kTubeSides; ++side) {
      const VertexId a = ring * kRow + side, b = a + 1, c = b + kRow, d = a + kRow;
      for (const Triangle& t : {Triangle{a, b, c}, Triangle{a, c, d}}) {
        surface.triangles.push_back(t);
        surface.object_of.push_back(ring < kTubeRings / 2 ? 0 : 1);
        surface.material_of.push_back(side + 1 == kTubeSides ? 1 : 0);
      }
    }
  const Eigen::Index count = surface.vertices.size();
  render.rows = BasisRows::NullaryExpr(3 * count, r, [&] { return uniform(generator); });
  for (Eigen::Index ring = 0; ring < kTubeRings; ++ring)
    render.rows.middleRows(3 * (ring * kRow + kTubeSides), 3) =
        render.rows.middleRows(3 * ring * kRow, 3);
  return render;
}

inline BasisData sample_render_basis(const StrainModel& model) {
  BasisData data = sample_basis(model);
  data.render = tube(model.omega.size());
  return data;
}

}  // namespace tremolo::testing
