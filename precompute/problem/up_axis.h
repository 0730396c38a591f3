// --up: which axis of the files points up.
#pragma once

#include <string>
#include <vector>

#include "common/mesh/render_surface.h"
#include "common/mesh/tet_mesh.h"
#include "formats/mesh/mesh_reader.h"

namespace tremolo {

// Turns what has y up so that z is up, about the x axis: (x, y, z) -> (x, -z, y), without rounding.
void turn_y_to_z(TetMesh& mesh);
void turn_y_to_z(RenderSurface& surface);
void turn_y_to_z(std::vector<FileMaterial>& materials);  // their axes

// What a user should know who takes the lowest slice along z of a body that has y up, by one of
// these selectors; empty if there is no sign of it. y_by_format: the file's format says that y is
// up. Else the body must stand on a plane foot along y, with nothing like it at y's other end and
// at z's low end.
std::string side_hint(const std::vector<std::string>& selectors, const TetMesh& mesh,
                      bool y_by_format);

// Whether files of this name have y up by the definition of their format: glTF, X3D.
bool has_y_up(const std::string& path);

}  // namespace tremolo
