// runtime/tremolo_scene.h: recording of worlds.
#include <memory>

#include "runtime/c/record_c_api.h"
#include "runtime/c/world_c_api.h"
#include "runtime/io/exchange/world_tracks.h"

using tremolo::Status;
using tremolo::World;
using tremolo::WorldTracks;

tremolo_status tremolo_recorder_record_world(tremolo_recorder* recorder, const tremolo_world* world,
                                             int32_t colliders) {
  return tremolo::c_api::with_world(
      world, {{recorder, "the recorder"}}, [&](const World& all) -> Status {
        if (recorder->world != nullptr && recorder->world != world)
          return tremolo::usage_error("the recorder records another world");
        if (recorder->world == nullptr) {
          recorder->tracks = std::make_shared<WorldTracks>();
          recorder->world = world;
        }
        return static_cast<WorldTracks*>(recorder->tracks.get())
            ->record(tremolo::things_of(all, colliders != 0), recorder->recording);
      });
}
