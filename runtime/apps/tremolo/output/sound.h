// The sound of vibrating bodies: `tremolo run --wav`.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/integrator.h"
#include "runtime/model.h"

namespace tremolo {

// The step that --wav takes where --step does not say another, s.
inline constexpr double kSoundStep = 1.0 / 48000.0;

// path: of --wav; listen: of --listen; step: s. Errors: kUsage for an ending that is not .wav and
// for a `listen` without a path, kContent for a step that is not that of a whole number of samples
// a second from 8 000 to 192 000.
Status check_sound(const std::string& path, const std::string& listen, double step);

// The largest relative frequency error of an audible mode: 5 cents, less than an ear can
// distinguish. Above it --wav takes several steps per sample.
inline constexpr double kSoundError = 3e-3;

// Accuracy of a method for the modes below half the sample rate.
struct SoundFit {
  double worst = 0.0;      // the largest relative error of a frequency
  double frequency = 0.0;  // of that mode, Hz
  double heard = 0.0;      // the frequency in the sound, Hz
};
SoundFit fit_of_sound(const Model& model, std::string_view method, const IntegratorOptions& options,
                      double rate);

// The least number of steps a sample, at `rate` samples a second, with which the error is at most
// kSoundError and an explicit method is stable; kMostSoundSteps if none is enough.
inline constexpr int kMostSoundSteps = 64;
int steps_a_sample(const Model& model, std::string_view method, const IntegratorOptions& options,
                   double rate);

// The warning about a step that shifts a mode; empty where none is shifted. options.step: s.
std::string sound_warning(const Model& model, std::string_view method,
                          const IntegratorOptions& options, double rate);

// The sound of a small area of a surface, in air far away, is proportional to its acceleration
// along the normal. An ear hears the mean of those of some vertices of one body.
class Ear {
 public:
  // listen: a vertex or selector; empty: the vertices of the default load. Errors of the selector;
  // kContent for a vertex that is not on the boundary, does not move, or has no normal, and for a
  // model without a default load.
  // Modes above half the rate, samples a second, are left out: in the file they would have another
  // frequency.
  static Result<Ear> create(const std::string& listen, const Model& model, double rate);

  // The mean displacement along the normal, m. q: r.
  double place(const Eigen::VectorXd& q) const { return along_.dot(q); }

 private:
  explicit Ear(Eigen::VectorXd along) : along_(std::move(along)) {}

  Eigen::VectorXd along_;  // n^T U, the mean of the vertices, r
};

// The sound of one ear, or of the sum of several at equal distances.
class SoundTrack {
 public:
  // place: the mean displacement at the start and then at every sample, m.
  void add(double place) { places_.push_back(place); }

  // Writes the second differences of the displacement, scaled so that the loudest sample is at 0.9,
  // and prints the acceleration of that sample. interval: between samples, s.
  Status write(const std::string& path, double interval) const;

 private:
  std::vector<double> places_;
};

}  // namespace tremolo
