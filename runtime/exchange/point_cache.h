// Point caches: the positions of one body's vertices, frame by frame, in the world. Blender's Mesh
// Cache modifier and 3ds Max read PC2; LightWave and Maya read MDD, as Blender does. Both formats
// have no triangles: the mesh that they move must have the same vertices in the same order, as the
// rest shape (rest_obj) written next to them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "runtime/exchange/animation.h"

namespace tremolo {

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

}  // namespace tremolo
