// The report of the run of a scene with [[bodies]]: its JSON, its warnings and the printed lines.
#pragma once

#include <cstdint>
#include <vector>

#include <nlohmann/json.hpp>

#include "runtime/apps/tremolo/output/warnings.h"
#include "runtime/apps/tremolo/run/follow.h"
#include "runtime/apps/tremolo/world/body_log.h"
#include "runtime/io/scenes/scene_reader.h"
#include "runtime/world/scene_world.h"

namespace tremolo {

// Frames that move at the start, steps that are too long, shapes and springs that are out of range,
// and, after a run, bodies that went deep into others.
Warnings world_warnings(const Scene& scene, const SceneWorld& world);
// Cloths whose particles went deeper than their thickness. guests: as in the report.
void add_sheet_warnings(const std::vector<nlohmann::ordered_json>& guests, Warnings& warnings);

// The largest extension of each joint so far, m: its difference from its length; of a weld the root
// of the mean square of its springs.
class JointStretch {
 public:
  void observe(const SceneWorld& world);
  // Warnings of joints without a stiffness of their own that did not hold.
  void add_warnings(const SceneWorld& world, Warnings& warnings) const;

 private:
  std::vector<double> most_;
};

nlohmann::ordered_json world_json(const SceneFile& file, const SceneWorld& world,
                                  const std::vector<BodyLog>& logs,
                                  const std::vector<nlohmann::ordered_json>& guests,
                                  const WorldEnding& ending, double momentum_error,
                                  const Warnings& warnings);

// Prints the energies, contacts and files of the first bodies.
void print_bodies(const SceneFile& file, const SceneWorld& world, const std::vector<BodyLog>& logs);

}  // namespace tremolo
