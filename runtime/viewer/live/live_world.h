// A running world with its last two states and the user's hand.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/viewer/live/live_hand.h"
#include "runtime/viewer/live/viewed_scene.h"
#include "runtime/viewer/live/world_moment.h"

namespace tremolo {

class LiveWorld {
 public:
  // Errors of SceneWorld::create, and of the bodies' starts.
  static Result<LiveWorld> create(const ViewedScene& viewed, ModelCache& models);

  // Restarts with the present methods and step.
  Status begin_again(ModelCache& models);

  SceneWorld& world() { return *world_; }
  const SceneWorld& world() const { return *world_; }
  const ViewedScene& viewed() const { return viewed_; }
  LiveHand& hand() { return hand_; }
  const LiveHand& hand() const { return hand_; }

  // Steps the world. A body whose step fails stays at rest from then on, and trouble() gives the
  // reason. Errors of look_at_world.
  Status step();
  // The message of the first body that failed; empty: none has. code: its exit code.
  const std::string& trouble() const { return trouble_; }
  int trouble_code() const { return trouble_code_; }

  // Moments before and after the last step; the same before the first.
  const WorldMoment& before() const { return moments_[1 - newest_]; }
  const WorldMoment& now() const { return moments_[newest_]; }
  // The state at t, s, interpolated between these two; outside of them the nearer one.
  void at(double t, WorldMoment& out) const;
  // Looks again, where something has been changed from outside.
  Status refresh();

 private:
  LiveWorld() = default;
  Status begin(ModelCache& models);
  Status look(WorldMoment& moment) const;

  ViewedScene viewed_;
  std::unique_ptr<SceneWorld> world_;
  LiveHand hand_;
  std::vector<VertexRows> held_;  // by the scene's hands
  WorldMoment moments_[2];
  int newest_ = 0;
  std::string trouble_;
  int trouble_code_ = 0;
};

}  // namespace tremolo
