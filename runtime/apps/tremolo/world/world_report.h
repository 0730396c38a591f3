// The report of the run of a scene with [[bodies]]: its JSON, its warnings and the printed lines.
#pragma once

#include <cstdint>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime/apps/tremolo/output/warnings.h"
#include "runtime/apps/tremolo/world/body_log.h"
#include "runtime/apps/tremolo/world/scene_ending.h"
#include "runtime/io/scenes/scene_reader.h"
#include "runtime/world/scene_world.h"

namespace tremolo {

// The end of a run of a world.
struct WorldEnding : SceneEnding {
  double seconds = 0.0;         // of the steps: processor time, with several threads by the clock
  std::int64_t steps = 0;       // that this run made
  double momentum_error = 0.0;  // WorldMomentum::error()
};

// Frames that move at the start, steps that are too long, shapes and springs that are out of range.
Warnings world_warnings(const Scene& scene, const SceneWorld& world);

nlohmann::ordered_json world_json(const SceneFile& file, const SceneWorld& world,
                                  const std::vector<BodyLog>& logs,
                                  const std::vector<nlohmann::ordered_json>& guests,
                                  const WorldEnding& ending, const Warnings& warnings);

// Prints the energies, contacts and files of the first bodies.
void print_bodies(const SceneFile& file, const SceneWorld& world, const std::vector<BodyLog>& logs);

}  // namespace tremolo
