// `tremolo run`, `inspect` and `export` of scenes with [[cloths]] and of scenes with [[bodies]] of
// kind "tets". run_* and inspect_* print errors and return the exit code.
#pragma once

#include <string>

#include "common/result.h"
#include "runtime/apps/tremolo/command_line.h"
#include "runtime/apps/tremolo/export/motion_source.h"

namespace tremolo {

// text: of the scene file command.file.
int run_cloth_scene(const std::string& text, const SceneCommand& command);
int run_tets_scene(const std::string& text, const SceneCommand& command);
int inspect_cloth_scene(const std::string& text, const SceneCommand& command);
int inspect_tets_scene(const std::string& text, const SceneCommand& command);
Result<MotionSource> cloth_source(const std::string& text, const SceneCommand& command);
Result<MotionSource> tets_source(const std::string& text, const SceneCommand& command);

}  // namespace tremolo
