// Scene files with [[cloths]]: TOML -> ClothScene (docs/cloth.md, "Scenes").
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "runtime/cloth/cloth_scene.h"
#include "runtime/scene_reader/scene_keys.h"

namespace tremolo {

// text: the file's. files: further files of the scene: CSV files of gravity and motions.
struct ClothFile {
  std::string path;
  std::string text;
  ClothScene scene;
  SceneOutputs outputs;
  std::vector<std::string> files;
};

// Meshes and CSV files are relative to the scene file. Errors: kSystem if a file is unreadable;
// kContent with file, line and key for an unknown key or a wrong value, and for errors of
// check_scene.
Result<ClothFile> parse_cloths(std::string_view text, const std::string& path);

}  // namespace tremolo
