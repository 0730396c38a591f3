// Scenes whose [[bodies]] are of kind "tets": TOML -> TetScene (docs/tets.md).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "runtime/frames/pose.h"
#include "runtime/scene/scene.h"
#include "runtime/scene_reader/scene_reader.h"
#include "runtime/tets/motion/tet_group.h"

namespace tremolo {

// A body of tetrahedra as its scene says. model: the file of `tremolo-precompute tets`; made_by:
// the command that makes it, for errors. velocity, spin: of all of it, m/s and rad/s about its
// centre of mass. friction: with what it touches. creep: the speed below which friction is a
// creep, m/s (tet_contact.h).
struct TetSceneBody {
  std::string name;
  std::string model;
  std::string made_by;
  Pose pose;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();
  double friction = 0.3;
  double creep = kTetCreep;
  TetBodyOptions options;
};

// step, duration: s. gravity: m/s^2.
struct TetScene {
  std::string path;
  double step = 1.0 / 60.0;
  double duration = 10.0;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  TetGroupOptions group;
  std::vector<TetSceneBody> bodies;
  std::vector<SceneCollider> colliders;
  std::vector<std::string> files;  // CSV files that were read
  SceneOutputs outputs;
};

// Errors (kContent) with file, line and key; for a collider that moves or comes from a file.
Result<TetScene> parse_tets_scene(std::string_view text, const std::string& path);

}  // namespace tremolo
