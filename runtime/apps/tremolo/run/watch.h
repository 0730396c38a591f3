// Measures and writes everything that a run reports, step by step.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/energy.h"
#include "runtime/apps/tremolo/output/stretch.h"
#include "runtime/apps/tremolo/output/world_sound.h"
#include "runtime/apps/tremolo/run/body_files.h"
#include "runtime/apps/tremolo/run/follow.h"
#include "runtime/apps/tremolo/run/simulate.h"
#include "runtime/energy.h"

namespace tremolo {

class Watch : public WorldWatch {
 public:
  // world: of one body; block: of the run, steps. Measurements are made on a copy of the body,
  // which is set to each recorded state. steps: the number of the whole run. Scene and report must
  // outlive this. Errors of Body::create, Model::vertex and WorldSound::create.
  static Result<Watch> create(const BodyScene& scene, const SceneWorld& world, std::int64_t block,
                              const int* first_probe, std::int64_t steps, BodyFiles files,
                              RunReport& report);

  void note(const SceneWorld& world) override;
  // A failed step or an orbit beyond its energy bound ends the run, and the report says why.
  Status look(const SceneWorld& world, std::span<const SceneWorld::Failure> failures,
              WorldEnding& ending) override;

  // Completes the report and renames the files from their temporary names.
  Status finish();

 private:
  Watch(const BodyScene& scene, Body seen, std::int64_t steps, BodyFiles files, RunReport& report);
  Result<bool> observe(const Moment& moment);
  void note_energy(const Moment& moment, const Energy& energy);
  void note_split(const Moment& moment);
  void note_shape(const Moment& moment);

  const BodyScene* scene_;
  RunReport* report_;
  Body seen_;
  std::vector<Moment> moments_;  // of a block
  std::size_t noted_ = 0;
  BodyFiles files_;
  std::unique_ptr<SurfaceStretch> stretch_;
  Eigen::Matrix<double, 3, Eigen::Dynamic> probe_;
  ShownResponse probe_response_;
  std::optional<WorldSound> sound_;  // of --wav
  DriftMeter drift_;
  bool was_loaded_ = true;  // before the step
  ShapeLooks shape_looks_;
  std::int64_t shape_seen_ = -1;  // steps at the last measurement of the shape
  Moment last_;
  std::chrono::steady_clock::time_point flushed_ = std::chrono::steady_clock::now();
};

}  // namespace tremolo
