// Surfaces -> .obj, .ply or POV-Ray's mesh2.
#pragma once

#include <string>

#include "common/mesh/render_surface.h"
#include "common/mesh/surface_mesh.h"
#include "common/result.h"

namespace tremolo {

// The ending of `path` chooses: .obj (text), .ply (binary, little-endian, float) or .inc (a POV-Ray
// mesh2 named Surface with smooth normals). Metres. Written whole or not at all. Errors: kUsage for
// another ending, kSystem if the file cannot be written.
Status write_surface(const std::string& path, const SurfaceMesh& surface);

// The same for .ply only, with a colour per vertex.
Status write_painted_surface(const std::string& path, const SurfaceMesh& surface,
                             const std::vector<Colour>& colours);

// One unit normal a vertex: the area-weighted mean of its triangles' normals; zero where no
// triangle has the vertex.
std::vector<Eigen::Vector3d> vertex_normals(const SurfaceMesh& surface);

// Writes a drawn surface with everything that the format supports; extension and errors are as
// above.
//   .obj  text: v (followed by the colour), vt, vn; only the author's vertices if `sources` says
//         which are copies; an `o` line where the object changes, `usemtl` where the material
//         does, and a `mtllib` line if `library` names a file
//   .ply  binary, little-endian: positions, normals, texture coordinates (s, t) and colours
//   .inc  a POV-Ray mesh2 named Surface: positions, normals, texture coordinates
Status write_render_surface(const std::string& path, const RenderSurface& surface,
                            const std::string& library = "");

// The text of such an .mtl file: a `newmtl` for each material, with the mean colour of its
// triangles' vertices, or a light grey if the surface has no colours. Textures and shininess are
// not written.
std::string material_library(const RenderSurface& surface);

}  // namespace tremolo
