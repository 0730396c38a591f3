// Measures and writes everything that a run reports, step by step.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "common/energy.h"
#include "runtime/apps/tremolo/run/body_files.h"
#include "runtime/apps/tremolo/run/simulate.h"
#include "runtime/apps/tremolo/run/sound.h"
#include "runtime/apps/tremolo/run/stretch.h"
#include "runtime/energy.h"

namespace tremolo {

class Watch {
 public:
  // body: the run's; measurements are made on a copy, which is set to each recorded state. steps:
  // the number of the whole run. Scene and report must outlive this.
  // Errors of Body::create and Model::vertex.
  static Result<Watch> create(const BodyScene& scene, const Body& body, const int* first_probe,
                              std::int64_t steps, BodyFiles files, RunReport& report);

  // Takes the start and then every step, in order. False: the orbit has left its energy bound, and
  // the report says so.
  Result<bool> observe(const Moment& moment);

  // Writes the buffered rows, so that the CSV's temporary file can be followed.
  Status flush() { return files_.flush(); }
  // Completes the report and renames the files from their temporary names.
  Status finish();

 private:
  Watch(const BodyScene& scene, Body seen, std::int64_t steps, BodyFiles files, RunReport& report);
  void note_energy(const Moment& moment, const Energy& energy);
  void note_split(const Moment& moment);
  void note_shape(const Moment& moment);

  const BodyScene* scene_;
  RunReport* report_;
  Body seen_;
  BodyFiles files_;
  std::unique_ptr<SurfaceStretch> stretch_;
  Eigen::Matrix<double, 3, Eigen::Dynamic> probe_;
  std::optional<Ear> ear_;  // of --wav
  SoundTrack sound_;
  DriftMeter drift_;
  bool was_loaded_ = false;
  ShapeLooks shape_looks_;
  std::int64_t shape_seen_ = -1;  // steps at the last measurement of the shape
  Moment last_;
};

}  // namespace tremolo
