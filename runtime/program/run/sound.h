// What bodies sound like: `tremolo run --wav`.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/model.h"

namespace tremolo {

// The step that --wav takes where --step does not say another, s.
inline constexpr double kSoundStep = 1.0 / 48000.0;

// path: of --wav; step: s. Errors: kUsage for an ending that is not .wav, kContent for a step that
// is not that of a whole number of samples a second from 8 000 to 192 000.
Status check_sound(const std::string& path, double step);

// The sound of small places of a surface in air far away goes as their acceleration along the
// normal. An ear hears the mean of those of some vertices of one body.
class Ear {
 public:
  // listen: a vertex or selector; empty: the vertices of the default load. Errors of the selector;
  // kContent for a vertex that is not on the boundary, does not move, or has no normal, and for a
  // model without a default load.
  static Result<Ear> create(const std::string& listen, const Model& model);

  // The mean displacement along the normal, m. q: r.
  double place(const Eigen::VectorXd& q) const { return along_.dot(q); }

 private:
  explicit Ear(Eigen::VectorXd along) : along_(std::move(along)) {}

  Eigen::VectorXd along_;  // n^T U, the mean of the vertices, r
};

// The sound of one ear, or of the sum of several at equal distances.
class SoundTrack {
 public:
  // place: of the start and then of every step, m.
  void add(double place) { places_.push_back(place); }

  // Writes the second differences, the loudest sample at nine tenths; tells of what acceleration
  // that is. step: s.
  Status write(const std::string& path, double step) const;

 private:
  std::vector<double> places_;
};

}  // namespace tremolo
