// What the user's hand did, as hands of a scene.
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
  // When the world has begun anew, nothing has been done yet.
  void clear();
  // The hand has let go, or does so now.
  void end(double time);

  // Each holds a vertex with the springs that it had, and goes on straight lines through where it
  // was at the end of each step: in a world that begins alike it does the same.
  const std::vector<SceneHand>& hands() const { return hands_; }

 private:
  std::vector<SceneHand> hands_;
  bool holds_ = false;
};

// The scene that was viewed, with its method and step of now, and the hands behind its own ones: a
// world's file with every path as seen from `path`. Written whole or not at all. Errors: kContent
// for a body that begins as no scene with [[bodies]] can say; kSystem.
Status write_recorded_scene(const std::string& path, const LiveWorld& world,
                            const std::vector<SceneHand>& hands);

}  // namespace tremolo
