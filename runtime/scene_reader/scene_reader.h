// Scene files: TOML -> Scene (docs/reference.md, "Scenes"). A target of its own: the engine knows
// neither TOML nor CSV.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// What a run of the scene writes. out: a folder; empty: nothing. every: a CSV row every so many
// steps. surfaces: so many of each body, evenly spaced in time, as ply, obj or inc. save: the file
// of the world at the end; restore: of the one at which it begins; empty: none.
struct SceneOutputs {
  std::string out;
  int every = 1;
  int surfaces = 0;
  std::string surface_format = "ply";
  bool plot = false;
  std::string save;
  std::string restore;
};

// files: what the scene was read from beside `path`, the CSV files that it names.
struct SceneFile {
  std::string path;
  Scene scene;
  SceneOutputs outputs;
  std::vector<std::string> files;
};

// Whether a scene file is a world, one with [[bodies]]; files with one table a body are not. Errors
// as parse_world.
Result<bool> is_world(std::string_view text, const std::string& path);

// Models and CSV files are relative to the scene file. Errors: kSystem if a file is unreadable;
// kContent with file, line and key for a key that is unknown or whose value is wrong, and for what
// check_scene finds; CSV files with their own lines.
Result<SceneFile> read_world(const std::string& path);
// The same of the file's contents.
Result<SceneFile> parse_world(std::string_view text, const std::string& path);

}  // namespace tremolo
