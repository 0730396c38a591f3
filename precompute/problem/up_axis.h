// --up: the axis of the input files that points up.
#pragma once

#include <string>
#include <vector>

#include "common/mesh/render_surface.h"
#include "common/mesh/selector.h"
#include "common/mesh/tet_mesh.h"
#include "formats/mesh/mesh_reader.h"

namespace tremolo {

// Rotates from y up to z up about the x axis: (x, y, z) -> (x, -z, y), without rounding.
void turn_y_to_z(TetMesh& mesh);
void turn_y_to_z(RenderSurface& surface);
void turn_y_to_z(std::vector<FileMaterial>& materials);  // rotates their axes

// Returns a hint for a user who selects the low end of z of a body that appears to have y up; empty
// if nothing suggests that. y_by_format: the file's format defines y as up. Otherwise the body must
// stand on a plane foot along y, with no comparable plane at the high end of y or the low end of z.
std::string side_hint(const std::vector<Selector>& selectors, const TetMesh& mesh,
                      bool y_by_format);

// Returns whether the file's format defines y as up: glTF, X3D.
bool has_y_up(const std::string& path);

}  // namespace tremolo
