// RenderSurface -> .obj, .ply or POV-Ray's mesh2, with all that the format can carry.
#pragma once

#include <string>

#include "common/mesh/render_surface.h"
#include "common/result.h"

namespace tremolo {

// The ending of `path` chooses. Metres; normals are written if the surface has them.
//   .obj  text: v (and the colour behind it), vt, vn; an `o` line where the object changes,
//   `usemtl`
//         where the material does, and a `mtllib` line if `library` names a file
//   .ply  binary, little-endian: positions, normals, texture coordinates (s, t) and colours
//   .inc  a POV-Ray mesh2 named Surface: positions, normals, texture coordinates
// Written whole or not at all. Errors: kUsage for another ending, kSystem if the file cannot be
// written.
Status write_render_surface(const std::string& path, const RenderSurface& surface,
                            const std::string& library = "");

// What such an .mtl file holds: a `newmtl` for each material, with the mean colour of its
// triangles' vertices, or a light grey where the surface has no colours. Textures and shininess are
// not known here.
std::string material_library(const RenderSurface& surface);

}  // namespace tremolo
