// tiny_basis() with a render surface that has everything a surface can have: a square of two
// triangles over the tetrahedra's corner, split along its diagonal by texture coordinates.
#pragma once

#include "tests/support/tiny_basis.h"

namespace tremolo::testing {

inline RenderBlock tiny_render() {
  RenderBlock render;
  RenderSurface& surface = render.surface;
  surface.vertices = {{0, 0, 1}, {0.5, 0, 1}, {0.5, 0.5, 1}, {0, 0, 1}, {0.5, 0.5, 1}, {0, 0.5, 1}};
  surface.triangles = {{0, 1, 2}, {3, 4, 5}};
  surface.normals.assign(6, Eigen::Vector3f(0, 0, 1));
  surface.uvs = {{0, 0}, {0.5f, 0}, {0.5f, 0.5f}, {0.5f, 0.5f}, {1, 1}, {0.5f, 1}};
  surface.colours = {{255, 0, 0, 255}, {255, 0, 0, 255}, {0, 0, 255, 255},
                     {255, 0, 0, 255}, {0, 0, 255, 255}, {1, 2, 3, 4}};
  surface.object_of = {0, 1};
  surface.material_of = {0, 0};
  surface.objects = {"lid", "left half"};
  surface.materials = {"Blech"};
  render.anchors = {3, 3, 4, 3, 4, 2};
  render.rows = BasisRows::Zero(18, 2);
  for (Eigen::Index row = 0; row < 18; ++row)
    render.rows.row(row) << 0.0625 * static_cast<double>(row), 0.5;
  // Vertices at one position move together.
  render.rows.middleRows(9, 3) = render.rows.middleRows(0, 3);
  render.rows.middleRows(12, 3) = render.rows.middleRows(6, 3);
  return render;
}

inline BasisData tiny_render_basis() {
  BasisData data = tiny_basis();
  data.render = tiny_render();
  return data;
}

}  // namespace tremolo::testing
