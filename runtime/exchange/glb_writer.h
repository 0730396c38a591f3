// An animation as one .glb file, glTF 2.0.
//
// Modes are morph targets and q their weights over time (runtime/exchange/morph_targets.h); poses
// are translations and rotations of nodes; bones are the joints of a skin, which glTF blends
// as runtime/skeleton/skin.h does. Data is in the meshes' coordinates; one root node turns z up
// into glTF's y up. A body's vertices are split by nothing but what split them before, so that
// their order is that of the surfaces that `tremolo run` writes. Triangles of one material are a
// primitive each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/exchange/animation.h"

namespace tremolo {

// The base colour of the material of this name, or of all without one: a .png or .jpg file.
struct GlbTexture {
  std::string material;
  std::string path;
};

// plain: weights are q itself instead of numbers in [0, 1]; programs that clamp weights then show
// something else. normals: of vertices and targets. z_up: the world's up is z, else y.
struct GlbOptions {
  bool plain = false;
  bool normals = true;
  bool z_up = true;
  std::vector<GlbTexture> textures;
};

// Weights of a body that viewers are asked to hold. WebGL2 guarantees textures of so many layers,
// and one target takes a layer.
inline constexpr std::size_t kMostGlbTargets = 256;

// bytes: of the file. targets: the most of a shape. dropped: coordinates of all shapes that never
// change. position_error: share of the size, normal angles in degrees (MorphError). bones_a_vertex:
// the most that carry one vertex. four_bones_error: share of the size by which programs that read
// the four heaviest of them, as glTF asks of all, show a vertex elsewhere at most.
struct GlbReport {
  std::uint64_t bytes = 0;
  std::size_t vertices = 0;
  std::size_t targets = 0;
  std::size_t dropped = 0;
  double position_error = 0.0;
  double normal_mean = 0.0;
  double normal_max = 0.0;
  std::size_t bones_a_vertex = 0;
  double four_bones_error = 0.0;
};

// Errors: check_animation's; kUsage for a texture of a material that is not there or without
// texture coordinates; kContent for more than kMostGlbTargets targets, more than 4 GB, or a file
// that is neither .png nor .jpg; kSystem.
Result<GlbReport> write_glb(const std::string& path, const Animation& animation,
                            const GlbOptions& options = {});

}  // namespace tremolo
