// SurfaceMesh -> .obj, .ply or POV-Ray's mesh2.
#pragma once

#include <string>

#include "common/mesh/surface_mesh.h"
#include "common/result.h"

namespace tremolo {

// The ending of `path` chooses: .obj (text), .ply (binary, little-endian, float) or .inc (a POV-Ray
// mesh2 named Surface with smooth normals). Metres. Written whole or not at all. Errors: kUsage for
// another ending, kSystem if the file cannot be written.
Status write_surface(const std::string& path, const SurfaceMesh& surface);

// The same as .ply alone, with a colour a vertex.
Status write_painted_surface(const std::string& path, const SurfaceMesh& surface,
                             const std::vector<Colour>& colours);

// One unit normal a vertex: the area-weighted mean of its triangles' normals; zero where no
// triangle has the vertex.
std::vector<Eigen::Vector3d> vertex_normals(const SurfaceMesh& surface);

}  // namespace tremolo
