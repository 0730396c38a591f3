// The skeleton that a surface's author gave it: bones, weights, recorded motions.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace tremolo {

inline constexpr std::int32_t kNoParent = -1;

struct RigBone {
  std::string name;                     // each once
  std::int32_t parent = kNoParent;      // a bone before this one
  Eigen::Vector3d head{0.0, 0.0, 0.0};  // at rest, m
  Eigen::Vector3d tail{0.0, 0.0, 0.0};  // its first child's head, or its own, m
};

// A part of a vertex that a bone carries; the parts of a vertex sum to 1.
struct RigWeight {
  std::int32_t vertex = 0;  // of the surface
  std::uint32_t bone = 0;
  float weight = 0.0F;
};

// A rigid motion from rest, in the surface's coordinates: x -> rotation x + position.
struct RigPose {
  Eigen::Vector3d position{0.0, 0.0, 0.0};  // m
  Eigen::Quaterniond rotation{1.0, 0.0, 0.0, 0.0};
};

struct RigClip {
  std::string name;
  std::vector<double> times;   // s, ascending
  std::vector<RigPose> poses;  // of all bones, for each frame
};

struct SurfaceRig {
  std::vector<RigBone> bones;      // parents before children, at least one
  std::vector<RigWeight> weights;  // ascending by vertex, then by bone
  std::vector<RigClip> clips;
};

// Checks indices, order and sizes for a surface of `vertices`, that all numbers are finite, and
// that the weights of each vertex sum to 1 within a thousandth.
bool rig_holds(const SurfaceRig& rig, std::size_t vertices);

}  // namespace tremolo
