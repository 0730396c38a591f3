// Surface files of modelling programs and scanners -> RenderSurface, through assimp.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/mesh/render_surface.h"
#include "common/result.h"

namespace tremolo {

// Options and limits of reading.
struct SurfaceReadOptions {
  double metres_per_unit = 0;  // factor of the coordinates; 0: the file's unit, by default metres
  double seconds = 60;         // limit of the time
  std::uint64_t bytes = 0;     // limit of the memory; 0: by the file's size
};

// A surface file's contents.
struct SurfaceFile {
  // All objects at their positions in the file's scene; polygons are divided into triangles; points
  // and lines are left out and noted.
  RenderSurface surface;
  std::string format;  // "Wavefront OBJ"
  double metres_per_unit = 1;
  std::string unit;  // the origin of metres_per_unit, in words for the user
  std::vector<std::string> notes;
};

// By the extension: obj, ply, stl, off, gltf, glb, fbx, dae, 3ds, ...; not the formats of
// read_tet_mesh.
bool is_surface_file(const std::string& path);

// assimp runs in a child process with limits, which a malformed file can crash without harm. The
// child's answer is treated as untrusted. Errors: kSystem for a file that is missing or unreadable;
// kContent for one that assimp refuses, crashes on, needs too much time or memory for, or that has
// no triangles.
Result<SurfaceFile> read_surface(const std::string& path, const SurfaceReadOptions& options = {});

}  // namespace tremolo
