// The motions of a scene file: tables and CSV files -> Motion.
#pragma once

#include <string>
#include <vector>

#include <toml++/toml.h>

#include "common/result.h"
#include "runtime/scene/motion.h"
#include "runtime/scene_reader/toml_keys.h"

namespace tremolo {

// position and quaternion, or turn, of a table. The quaternion comes out of length one.
Pose read_pose(TomlKeys& keys);

// A part of a motion. path: of the scene. what: its name in errors. files: those that were read are
// added. Errors as read_world.
Result<MotionPart> read_motion_part(const toml::table& table, const std::string& path,
                                    const std::string& what, std::vector<std::string>& files);

// All parts of the key `motion` of a table that is named `what`. placed: what moves has a
// `position`, so that `frame = "world"` means something; refused else.
Result<Motion> read_motion(TomlKeys& keys, const std::string& path, const std::string& what,
                           std::vector<std::string>& files, bool placed = false);

}  // namespace tremolo
