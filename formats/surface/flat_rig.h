// A rig as the plain arrays in which files and processes hand it on.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/mesh/render_surface.h"

namespace tremolo {

struct FlatRig {
  std::string names;                   // of bones, each ended by a zero byte
  std::vector<std::uint32_t> parents;  // one per bone; 0xffffffff: none
  std::vector<double> ends;            // six a bone: head, tail
  std::vector<std::uint32_t> places;   // two per weight: vertex, bone
  std::vector<float> weights;
  std::string clip_names;                  // as the bones'
  std::vector<std::uint32_t> clip_frames;  // one per clip: its number of frames
  std::vector<double> clip_times;          // of all clips, in order
  std::vector<double> clip_poses;          // seven a frame and bone: x, y, z, then w, x, y, z
};

FlatRig flatten(const SurfaceRig& rig);

// Null unless the sizes of the arrays agree and rig_holds() for a surface of so many vertices.
std::shared_ptr<const SurfaceRig> unflatten(const FlatRig& flat, std::size_t vertices);

}  // namespace tremolo
