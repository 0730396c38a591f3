// The recorder of runtime/tremolo.h, for the functions of bodies and of worlds.
#pragma once

#include <memory>

#include "runtime/c/c_api.h"
#include "runtime/io/exchange/recording.h"

// NOLINTBEGIN(readability-identifier-naming): the names of the C header
struct tremolo_recorder {
  tremolo::Recording recording;
  // The world that it records and its tremolo::WorldTracks; null: none. The functions of bodies are
  // linked without worlds.
  const void* world = nullptr;
  std::shared_ptr<void> tracks = {};
};
// NOLINTEND(readability-identifier-naming)

namespace tremolo::c_api {

// Runs action(recorder) -> Status; kUsage for NULL, also of a further argument.
template <class Action>
tremolo_status recording(tremolo_recorder* recorder, std::initializer_list<Argument> further,
                         const Action& action) noexcept {
  return guarded([&]() -> Status {
    if (Status s = need({{recorder, "the recorder"}}); !s) return s;
    if (Status s = need(further); !s) return s;
    return action(*recorder);
  });
}

}  // namespace tremolo::c_api
