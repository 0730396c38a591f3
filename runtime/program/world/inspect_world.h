// `tremolo inspect` of scenes whose bodies have bases.
#pragma once

#include <vector>

#include "runtime/program/run/run_options.h"
#include "runtime/scene_reader/scene_reader.h"

namespace tremolo {

// A scene with [[bodies]]; returns the exit code. Errors are those with which a run would end before
// its first step.
int inspect_world_command(const SceneFile& file, bool json);

// For a scene with one table per body; each body is in a world of its own.
int inspect_bodies_command(const std::vector<RunOptions>& bodies, const std::string& path,
                           bool json);

}  // namespace tremolo
