// The sound of a world: the sum over its bodies, all at equal distance.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/result.h"
#include "runtime/apps/tremolo/output/sound.h"
#include "runtime/world/scene_world.h"

namespace tremolo {

// The least number of steps a sample with which each body's modes keep their frequencies
// (steps_a_sample()). The world's step is that of the samples.
int steps_a_sample(const SceneWorld& world);
// The warnings about a step that shifts modes, one per model. rate: samples per second.
std::vector<std::string> sound_warnings(const SceneWorld& world, double rate);

class WorldSound {
 public:
  // listen: of --listen, "BODY:SELECTOR", where BODY is a body's name or that of its copies, or a
  // selector alone, for all bodies that are not rigid; empty: the default load of bodies that have
  // one. steps: per sample. Errors: those of Ear::create with the body's name; kContent if no body
  // is heard.
  static Result<WorldSound> create(const std::string& listen, const SceneWorld& world, int steps);

  // Call it at the start and after every step, with the number of steps and a function that returns
  // a body's q, r, by its index. Rigid motion makes no sound.
  template <class StateOf>
  void add(std::int64_t steps, const StateOf& q_of) {
    if (steps % steps_ != 0) return;
    double place = 0.0;
    for (const HeardBody& heard : heard_) place += heard.ear.place(q_of(heard.body));
    track_.add(place);
  }

  // True if all bodies are listened to, except this one because it is rigid.
  bool leaves_out(std::size_t body) const {
    return std::find(left_out_.begin(), left_out_.end(), body) != left_out_.end();
  }

  // As SoundTrack::write.
  Status write(const std::string& path) const { return track_.write(path, interval_); }

 private:
  struct HeardBody {
    std::size_t body;
    Ear ear;
  };

  WorldSound(int steps, double interval) : steps_(steps), interval_(interval) {}

  std::vector<HeardBody> heard_;
  std::vector<std::size_t> left_out_;  // rigid bodies
  int steps_;                          // a sample
  double interval_;                    // between samples, s
  SoundTrack track_;
};

}  // namespace tremolo
