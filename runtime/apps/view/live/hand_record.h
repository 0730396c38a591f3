// A record of the user's grabs, as hands of a scene.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <toml++/toml.h>

#include "common/result.h"
#include "runtime/apps/view/live/live_world.h"
#include "runtime/math/motion.h"
#include "runtime/scene/scene.h"

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

class HandRecord {
 public:
  // Before and after each step of the world.
  void before_step(const LiveWorld& world);
  // Discards all records, when the world restarts.
  void clear();
  // Ends the grab at `time`, s, if one is active.
  void end(double time);

  // Each hand holds a vertex with the same springs and moves on straight lines through its
  // positions at the ends of the steps: in a world with the same start it gives the same motion.
  const std::vector<SceneHand>& hands() const { return hands_; }

 private:
  std::vector<SceneHand> hands_;
  bool holds_ = false;
};

// Writes the viewed scene with its present methods and step, and with these hands after its own, as
// a world's file; paths are relative to that of the file. Written whole or not at all. Errors:
// kContent for a body whose start a scene with [[bodies]] cannot express; kSystem.
Status write_recorded_scene(const std::string& path, const LiveWorld& world,
                            const std::vector<SceneHand>& hands);

}  // namespace tremolo
