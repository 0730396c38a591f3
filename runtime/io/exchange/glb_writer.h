// An animation as one .glb file, glTF 2.0.
//
// Modes are morph targets and q their weights over time (runtime/io/exchange/morph_targets.h);
// poses are translations and rotations of nodes; bones are the joints of a skin, which glTF blends
// as runtime/bodies/reduced/bones/skin.h does. Data is in the meshes' coordinates; one root node
// rotates z up to glTF's y up. The first vertices are those of the surfaces that `tremolo run`
// writes, in their order; those behind them are at sharp edges (creased_animation.h). Triangles of
// one material form a primitive.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/io/exchange/animation.h"

namespace tremolo {

// The base colour of the material of this name, or of all without one: a .png or .jpg file.
struct GlbTexture {
  std::string material;
  std::string path;
};

// plain: weights are q itself instead of numbers in [0, 1]; programs that clamp weights then show
// something else. normals: of vertices and targets. normal_targets: targets of normals alone, at
// most, which bring the normals of strongly bent shapes nearer to theirs
// (runtime/io/exchange/bent_normals.h). z_up: the world's up is z, else y.
struct GlbOptions {
  bool plain = false;
  bool normals = true;
  std::size_t normal_targets = 0;
  bool z_up = true;
  std::vector<GlbTexture> textures;
};

// The largest number of weights of a body. WebGL2 guarantees textures with so many layers, and a
// target takes one layer.
inline constexpr std::size_t kMostGlbTargets = 256;

// Size and accuracy of a file.
struct GlbReport {
  std::uint64_t bytes = 0;  // of the file
  std::size_t vertices = 0;
  std::size_t targets = 0;         // the most of a shape, without those of normals alone
  std::size_t normal_targets = 0;  // the most of a shape, of normals alone
  std::size_t dropped = 0;         // coordinates of all shapes that never change
  double position_error = 0.0;     // relative to the size (MorphError)
  double normal_mean = 0.0;        // degrees
  double normal_max = 0.0;         // degrees
  std::size_t bones_a_vertex = 0;  // the most bones of a vertex
  // The largest error of a vertex, relative to the size, in programs that read only the four
  // largest weights of a vertex, the minimum that glTF requires.
  double four_bones_error = 0.0;
};

// Errors: check_animation's; kUsage for a texture of a material that is not there or without
// texture coordinates; kContent for more than kMostGlbTargets targets, more than 4 GB, or a file
// that is neither .png nor .jpg; kSystem.
Result<GlbReport> write_glb(const std::string& path, const Animation& animation,
                            const GlbOptions& options = {});

}  // namespace tremolo
