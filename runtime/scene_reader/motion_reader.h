// The motions of a scene file: tables and CSV files -> Motion.
#pragma once

#include <string>
#include <vector>

#include <toml++/toml.h>

#include "common/result.h"
#include "runtime/scene/motion.h"
#include "runtime/scene_reader/toml_keys.h"

namespace tremolo {

// Reads position and quaternion, or turn, of a table. The quaternion is normalised.
Pose read_pose(TomlKeys& keys);

// Reads a part of a motion. path: of the scene. what: its name in errors. files: CSV files that
// were read are added. Errors as for read_world.
Result<MotionPart> read_motion_part(const toml::table& table, const std::string& path,
                                    const std::string& what, std::vector<std::string>& files);

// Reads all parts of the key `motion` of a table. what: its name in errors. placed: the moving
// thing has a `position`, which `frame = "world"` requires.
Result<Motion> read_motion(TomlKeys& keys, const std::string& path, const std::string& what,
                           std::vector<std::string>& files, bool placed = false);

}  // namespace tremolo
