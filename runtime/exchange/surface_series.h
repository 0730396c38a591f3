// Series of files, one per frame: surfaces in the world as .ply or .obj, and .vtu files with a .pvd
// that lists them for ParaView.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/exchange/animation.h"
#include "runtime/exchange/point_cache.h"

namespace tremolo {

// "OUT.csv": the list of a series.
std::string list_of_series(const std::string& path);
// "OUT-frames": the folder of a .pvd's files.
std::string folder_of_pvd(const std::string& path);
// Files that are there and that a series of this name may write over or remove, whatever it holds:
// OUT-0000.ply, OUT-NAME-0000.ply ...; of a .pvd the .vtu files in its folder.
std::vector<std::string> files_of_series(const std::string& path);
std::vector<std::string> files_of_pvd(const std::string& path);

// "OUT.ply" or "OUT.obj" -> OUT-0000.ply ...; for several bodies OUT-NAME-0000.ply ...; with
// normals of the deformed shape if the surface has normals. OUT.csv lists them: frame, t (s), body,
// file. Scenery is left out. Files in an earlier list that are not in this one are removed: those
// of a longer series or of other bodies. Errors: check_animation's; kUsage for another extension;
// kSystem. The list is written last; it is first in the result.
Result<std::vector<WrittenFile>> write_surface_series(const std::string& path,
                                                      const Animation& animation);

// "OUT.pvd" and OUT-frames/NAME-0000.vtu ...: triangles in the world, float, with the point data
// `displacement`: that of a vertex relative to its body's pose, along the world's axes, m. A body
// at rest is written once. times: s, exact; part: the body. Errors as above; the folder is made if
// need be.
Result<std::vector<WrittenFile>> write_pvd(const std::string& path, const Animation& animation);

}  // namespace tremolo
