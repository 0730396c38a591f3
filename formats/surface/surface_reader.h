// Surface files of modelling programs and scanners -> RenderSurface, through assimp.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/mesh/render_surface.h"
#include "common/result.h"

namespace tremolo {

// metres_per_unit: what coordinates are multiplied by; 0: what the file says of its unit, and one
// metre if it says nothing. seconds, bytes: what reading may take; bytes 0: by the file's size.
struct SurfaceReadOptions {
  double metres_per_unit = 0;
  double seconds = 60;
  std::uint64_t bytes = 0;
};

// surface: all objects, each where the file's scene puts it, polygons cut into triangles; points
// and lines are left out and noted. format: "Wavefront OBJ". unit: where metres_per_unit is from,
// in words for the user.
struct SurfaceFile {
  RenderSurface surface;
  std::string format;
  double metres_per_unit = 1;
  std::string unit;
  std::vector<std::string> notes;
};

// By the extension: obj, ply, stl, off, gltf, glb, fbx, dae, 3ds, ...; not what read_tet_mesh
// takes.
bool is_surface_file(const std::string& path);

// assimp runs in a child process with limits: what a file does to it, it does to the child. The
// child's answer is checked as if it came from a stranger. Errors: kSystem for a file that is
// missing or unreadable; kContent for one that assimp refuses, crashes on, takes too long or too
// much memory for, or that has no triangles.
Result<SurfaceFile> read_surface(const std::string& path, const SurfaceReadOptions& options = {});

}  // namespace tremolo
