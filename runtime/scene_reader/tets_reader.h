// Scenes whose [[bodies]] are of kind "tets": TOML -> TetScene (docs/tets.md).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "runtime/scene_reader/scene_reader.h"
#include "runtime/tets/scene/tet_scene.h"

namespace tremolo {

// step, duration: s. gravity: m/s^2.
struct TetScene : TetBodiesScene {
  double step = 1.0 / 60.0;
  double duration = 10.0;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  std::vector<std::string> files;  // CSV files that were read
  SceneOutputs outputs;
};

// Errors (kContent) with file, line and key; for a collider that moves or comes from a file.
Result<TetScene> parse_tets_scene(std::string_view text, const std::string& path);

}  // namespace tremolo
