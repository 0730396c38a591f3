// Scene files that the viewer writes: the text of the viewed scene, with hands appended.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <toml++/toml.h>

#include "common/result.h"
#include "runtime/scene/motion.h"

namespace tremolo {

// A hand's motion through keys: straight lines, no rotations. A key between two others at the same
// position is redundant and left out.
Motion hand_motion();
void add_hand_key(Motion& motion, double time, const Eigen::Vector3d& way);
toml::array hand_motion_table(const Motion& motion);

// A file's name as seen from a folder.
std::string named_from(const std::filesystem::path& folder, const std::filesystem::path& file);
// The table of a scene file that has been read before, every path in it as seen from `folder`.
toml::table moved_scene(const std::string& text, const std::string& file,
                        const std::filesystem::path& folder);

// Adds the hands to those that the scene has, and writes it, whole or not at all. Errors: kSystem.
Status write_scene_with_hands(const std::string& path, toml::table& table,
                              const std::vector<toml::table>& hands);

}  // namespace tremolo
