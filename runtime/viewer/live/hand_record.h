// A record of the user's grabs, as hands of a scene.
#pragma once

#include <vector>

#include "common/result.h"
#include "runtime/scene/scene.h"
#include "runtime/viewer/live/live_world.h"

namespace tremolo {

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
