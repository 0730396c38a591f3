// What a body sounds like: `tremolo run --wav`.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/model.h"
#include "runtime/program/run/run_options.h"

namespace tremolo {

// The step that --wav takes where --step does not say another, s.
inline constexpr double kSoundStep = 1.0 / 48000.0;

// kUsage for an ending that is not .wav, kContent for a step that is not that of a whole number of
// samples a second from 8 000 to 192 000.
Status check_sound(const RunOptions& options);

// The sound of small places of a surface in air far away goes as their acceleration along the
// normal: here the mean of those of the vertices that are listened to, by second differences of
// their displacement.
class SoundTrack {
 public:
  // Errors of the selector --listen; kContent for a vertex that is not on the boundary, does not
  // move, or has no normal. Without --listen the vertices of the default load, if they are there.
  static Result<SoundTrack> create(const RunOptions& options, const Model& model);

  // Takes the state of the start and then of every step.
  void add(const Eigen::VectorXd& q) { places_.push_back(along_.dot(q)); }

  // Writes the file, its loudest sample at nine tenths; tells of what acceleration that is.
  Status write(const RunOptions& options) const;

 private:
  explicit SoundTrack(Eigen::VectorXd along) : along_(std::move(along)) {}

  Eigen::VectorXd along_;       // n^T U, the mean of the vertices, r
  std::vector<double> places_;  // m along the normal, one a step
};

}  // namespace tremolo
