// Scene files: TOML -> Scene (docs/reference.md, "Scenes"). It is a separate target: the engine
// reads neither TOML nor CSV.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "runtime/io/scenes/scene_keys.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// Commands that accept a scene with [[cloths]], for the errors of those that do not.
inline constexpr const char* kClothCommands =
    "`tremolo run` runs it and writes its surfaces, and `tremolo export` --usda, --pc2, --mdd, "
    "--pvd "
    "and --series write what other programs show";

// Commands that accept a scene with bodies of kind "tets" or "cloth" next to others, for errors.
inline constexpr const char* kMixedCommands =
    "`tremolo run` runs such a scene and writes its surfaces, `tremolo view` shows it, `tremolo "
    "inspect` prints where its bodies are";

// files: CSV files that the scene names, which were read besides `path`.
struct SceneFile {
  std::string path;
  Scene scene;
  SceneOutputs outputs;
  std::vector<std::string> files;
};

// True if a scene file is a world, one with [[bodies]]; files with one table per body are not.
// Errors as for parse_world; kContent also for a scene with [[cloths]], which nodal_readers.h
// reads.
Result<bool> is_world(std::string_view text, const std::string& path);

// Models and CSV files are relative to the scene file. Errors: kSystem if a file is unreadable;
// kContent with file, line and key for an unknown key or a wrong value, and for errors of
// check_scene; CSV files with their own lines.
Result<SceneFile> read_world(const std::string& path);
// The same of the file's contents. others: bodies of kind "tets" and "cloth" among the others are
// refused, as by read_world(), or skipped (parse_mixed(), nodal_readers.h); Scene::guests is then
// set if there are any.
enum class OtherKinds { kRefused, kSkipped };
Result<SceneFile> parse_world(std::string_view text, const std::string& path,
                              OtherKinds others = OtherKinds::kRefused);

}  // namespace tremolo
