// Writers of an animation, one a format that is no glTF, and the one that a path's ending names.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "runtime/io/exchange/animation.h"

namespace tremolo {

// Formats without a word for it refuse a body that comes or goes within the motion (kUsage); in a
// .usda it is invisible, and a series and a .pvd have no file of it, in the other frames.

// Point caches: the positions of one body's vertices, frame by frame, in the world. Blender's Mesh
// Cache modifier and 3ds Max read PC2; LightWave and Maya read MDD, as Blender does. Both formats
// have no triangles: the mesh that they move must have the same vertices in the same order, as the
// rest shape (rest_obj) written next to them.

// A file that was written.
struct WrittenFile {
  std::string path;
  std::uint64_t bytes = 0;
};

// PC2, little-endian: "POINTCACHE2\0", int32 1, int32 vertices, float first frame 0, float 1 (one
// sample per frame), int32 frames; then float x, y, z of every vertex, for each frame. It has no
// times: sample k is frame k. Errors: check_animation's; kContent for more vertices or frames than
// an int32 can count; kSystem.
Result<WrittenFile> write_pc2(const std::string& path, const Animation& animation,
                              std::size_t body);

// MDD, big-endian: int32 frames, int32 vertices, float time of every frame (s), then as PC2.
Result<WrittenFile> write_mdd(const std::string& path, const Animation& animation,
                              std::size_t body);

// The body's rest shape as .obj in the mesh's coordinates: one object, with texture coordinates and
// materials.
Result<WrittenFile> write_rest_obj(const std::string& path, const Animation& animation,
                                   std::size_t body);

// "OUT.pc2" for one body that deforms, else "OUT-NAME.pc2": the file of this one. Letters, digits,
// '.', '_' and '-' of a name stay, others become '_'.
std::string path_of_body(const std::string& path, const Animation& animation, std::size_t body);
// Bodies that have coordinates: scenery has none.
std::vector<std::size_t> deforming_bodies(const Animation& animation);
// Converts a body's name to a part of a file name.
std::string file_name_of(std::string_view name);
// kUsage if two bodies would get the same file name.
Status check_file_names(const Animation& animation);
// "OUT" of "FOLDER/OUT.pc2" with its folder.
std::string without_ending(const std::string& path);

// All bodies that deform: their caches by the path's ending, .pc2 or .mdd, and their rest shapes.
Result<std::vector<WrittenFile>> write_point_caches(const std::string& path,
                                                    const Animation& animation);

// An animation in the format that a path's ending names. .glb, .usda, .pvd, .pc2 or .mdd, each as
// its writer writes without options; .ply or .obj: a numbered series. All files that were written.
// Errors: kUsage for another ending; the writers'.
Result<std::vector<WrittenFile>> write_animation(const std::string& path,
                                                 const Animation& animation);

// An animation as one .usda file: USD's text form. A stage in metres, its up axis z (z_up) or y,
// with an Xform `tremolo` and a Mesh for each body: `points` in the body's frame as time samples,
// floats of nine digits; `xformOp:translate` and `xformOp:orient` as time samples, or constant if
// the body is at rest. Points of a body on bones are in the world, without a pose.
// timeCodesPerSecond is Animation::rate, and a frame's time code its time, s, times that: exact,
// not rounded to whole codes. Texture coordinates are primvars:st, colours primvars:displayColor;
// materials become GeomSubsets without shaders. A body's name becomes an identifier: characters
// other than letters, digits and '_' become '_'. Errors: those of check_animation; kSystem.
Result<WrittenFile> write_usda(const std::string& path, const Animation& animation,
                               bool z_up = true);

// Series of files, one per frame: surfaces in the world as .ply or .obj, and .vtu files with a .pvd
// that lists them for ParaView.

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
