// Response curves: the periodic motions under a periodic force, over its frequency.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/response/equations/fourier_series.h"
#include "runtime/response/equations/vibrating_system.h"
#include "runtime/response/floquet.h"

namespace tremolo {

// H grows up to this where a program, C or Python does not say otherwise. A response beyond its
// first fold may need many harmonics; with few, its folds are some percent too high. A backbone
// enters internal resonances with each harmonic.
inline constexpr Eigen::Index kMostHarmonicsOfResponse = 25, kMostHarmonicsOfBackbone = 15;

// Options of response curves and backbones.
struct CurveOptions {
  Eigen::Index harmonics = 5;        // H at the start
  Eigen::Index most_harmonics = 15;  // H grows up to this
  // H grows by two where the two highest harmonics hold more than this share of the motion, or the
  // harmonics left out more than a tenth of it (CurvePoint::missing). It falls again, not below
  // `harmonics`, where both are far smaller.
  double harmonic_share = 1e-3;
  bool stability = true;      // compute Floquet multipliers and bifurcations
  int most_points = 4000;     // of a curve
  double longest_step = 0.1;  // along the curve, relative to the vibration's size and the frequency
  // The size of a motion, in the unit of largest_amplitude: m in the programs.
  std::function<double(const FourierSeries&)> amplitude;
  // The same with the factor of the load (CurvePoint::load), for a point that a force moves besides
  // the motion. Empty: `amplitude`.
  std::function<double(const FourierSeries&, double load)> loaded_amplitude;
  double largest_amplitude = 0.0;  // a curve ends there
  std::function<bool()> stopped;   // asked at every point; true ends the curve. May be empty
};

// One periodic motion of a curve.
struct CurvePoint {
  double omega = 0.0;  // rad/s
  FourierSeries motion;
  double amplitude = 0.0;  // options.amplitude of the motion
  double load = 1.0;       // factor of the load: of damped backbones and curves of folds
  double share = 0.0;      // of the two highest harmonics
  double missing = 0.0;    // estimate for the harmonics left out (HarmonicBalance::missing_share)
  bool stable = true;      // without options.stability: not known
  int unstable = 0;        // multipliers outside the unit circle
  double length = 0.0;     // along the curve from its first point, relative to the vibration's size
  // 2r, the largest first; empty without options.stability. Far from the unit circle they are
  // computed with half the steps: those of stiff coordinates may then be too large, never unstable.
  Eigen::VectorXcd multipliers;

  Eigen::Index harmonics() const { return harmonics_of(motion); }
};

// A point where the curve turns or its stability changes.
struct Bifurcation {
  BifurcationKind kind = BifurcationKind::kFold;
  CurvePoint point;
  std::complex<double> multiplier{1.0, 0.0};  // the one that crosses the unit circle
  // A branch point that is none: two curves pass each other there across a gap that is narrower
  // than a step, as those of a nearly symmetric body.
  bool imperfect = false;
};

// Reason for the end of a curve. kDone: the requested end. kUnbounded: the largest amplitude.
// kReturned: it left the range where it had begun. kStuck: no further point was found. kLong: the
// most points. kStopped: options.stopped. kJoined: a backbone ends on that of another mode with
// twice the frequency. kLoop: it came back onto itself (MotionCurve::loop_start). kCoarse: the
// highest harmonics hold too much for the points to be motions (CurveGoal::most_share).
enum class CurveEnd {
  kDone,
  kUnbounded,
  kReturned,
  kStuck,
  kLong,
  kStopped,
  kJoined,
  kLoop,
  kCoarse
};

const char* name_of(CurveEnd end);

struct MotionCurve {
  std::vector<CurvePoint> points;
  std::vector<Bifurcation> bifurcations;  // folds too, in the order of the curve
  CurveEnd end = CurveEnd::kDone;
  std::size_t loop_start = 0;  // kLoop: the point that it came back to
  double largest_share = 0.0;  // of the two highest harmonics, over all points
  // Points with too few harmonics since more of them gave no motion, and the frequency of the
  // first.
  int refused = 0;
  double first_refused = 0.0;  // rad/s
  // Of a backbone: the steps that kept it off a loop, where the ones asked for had led onto it; 0:
  // those of CurveOptions.
  double longest_step = 0.0;
};

// One harmonic of a load in time: scale sin(number omega t + phase).
struct LoadHarmonic {
  int number = 1;  // 1 to 99
  double scale = 1.0;
  double phase = 0.0;  // rad
};

// The sum of the harmonics as a series of one row, without a constant part; sin omega t if there
// are none. Errors: kContent for a number out of range, a value that is not finite, or no load.
Result<FourierSeries> load_course(std::span<const LoadHarmonic> parts);

// A response curve's force and range.
struct ResponseRequest {
  FourierSeries force;  // r x (2K + 1), N kg^-1/2; column 0: the constant part
  double omega_from = 0.0;
  double omega_to = 0.0;  // rad/s, positive, above or below omega_from
};

// Follows the curve from omega_from until omega_to, through folds. Errors: kContent for frequencies
// that are not positive, more harmonics in the force than most_harmonics, or a constant force
// beyond a static instability; kSolver if no motion is found at omega_from. A curve that ends early
// is not an error: MotionCurve::end is its reason.
Result<MotionCurve> response_curve(const VibratingSystem& system, const ResponseRequest& request,
                                   const CurveOptions& options);

// The motion of the linearized body about the state q0 (r), r x (2H + 1) with q0 in column 0.
// Error: kSolver if a harmonic meets an undamped frequency.
Result<FourierSeries> linear_motion(const VibratingSystem& system, const Eigen::VectorXd& q0,
                                    const FourierSeries& force, double omega,
                                    Eigen::Index harmonics);

}  // namespace tremolo
