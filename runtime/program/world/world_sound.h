// The sound of a scene with [[bodies]]: what each of them sounds like, at equal distances.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "common/result.h"
#include "runtime/program/run/sound.h"
#include "runtime/scene/scene_world.h"

namespace tremolo {

class WorldSound {
 public:
  // listen: of --listen, "BODY:SELECTOR", where BODY is a body's name or that of its copies, or a
  // selector alone, which every body is asked for; empty: the default load of those that have one.
  // Errors: those of Ear::create with the body's name; kContent if no body is heard.
  static Result<WorldSound> create(const std::string& listen, const SceneWorld& world);

  // Takes the start and then every step. What moves as a whole makes no sound by that.
  void add(const SceneWorld& world);

  // As SoundTrack::write.
  Status write(const std::string& path, double step) const { return track_.write(path, step); }

 private:
  struct HeardBody {
    std::size_t body;
    Ear ear;
  };

  std::vector<HeardBody> heard_;
  SoundTrack track_;
};

}  // namespace tremolo
