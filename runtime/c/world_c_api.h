// Calls on a world of runtime/tremolo_scene.h and its bodies.
#pragma once

#include "runtime/c/scene_c_api.h"

namespace tremolo::c_api {

inline tremolo_body_id id_of(WorldBody body) {
  return (static_cast<tremolo_body_id>(body.generation) << 32) | body.slot;
}
inline WorldBody body_of(tremolo_body_id id) {
  return {static_cast<std::uint32_t>(id), static_cast<std::uint32_t>(id >> 32)};
}

// Runs action(World&) -> Status; kUsage for NULL, also of a further argument, and for a world that
// is being stepped.
template <class Handle, class Action>
tremolo_status with_world(Handle* world, std::initializer_list<Argument> further,
                          const Action& action) noexcept {
  return guarded([&]() -> Status {
    if (Status s = need({{world, "the world"}}); !s) return s;
    if (Status s = need(further); !s) return s;
    if (world->world->is_stepping())
      return usage_error("the world is being stepped: a callback must not call it");
    return action(*world->world);
  });
}
// Runs action(World&, WorldBody) -> Status; kUsage also if there is no such body.
template <class Handle, class Action>
tremolo_status with_body(Handle* world, tremolo_body_id body,
                         std::initializer_list<Argument> further, const Action& action) noexcept {
  return with_world(world, further, [&](World& all) -> Status {
    const WorldBody known = body_of(body);
    if (body == 0) return usage_error("the body's id is 0");
    if (Status s = all.check(known); !s) return s;
    return action(all, known);
  });
}

// True if the call may read that body.
inline bool exists(const tremolo_world* world, tremolo_body_id body) {
  return world != nullptr && !world->world->is_stepping() &&
         static_cast<bool>(world->world->check(body_of(body)));
}

}  // namespace tremolo::c_api
