// Backbones: the free periodic motions of the undamped body (nonlinear normal modes), from a mode
// of small vibration to a large amplitude.
#pragma once

#include "runtime/response/response.h"

namespace tremolo {

struct BackboneRequest {
  Eigen::Index mode = 0;      // coordinate, or mode about the constant force's state, from 0
  Eigen::VectorXd constant;   // a constant force, r; empty: none
  double to_amplitude = 0.0;  // in the unit of options.amplitude; the curve's end
};

// The energy of the motion, J: V + q'^2/2, of which a free motion keeps all. The mean over a
// period.
double mean_energy(const VibratingSystem& system, const FourierSeries& motion, double omega);

// The free motion's largest energy share of one harmonic in one coordinate, other than the first
// harmonic: what an internal resonance feeds.
struct HarmonicPart {
  Eigen::Index harmonic = 0;    // 2 or more
  Eigen::Index coordinate = 0;  // from 0
  double share = 0.0;           // of the kinetic energy, 0 to 1
};
HarmonicPart largest_part(const FourierSeries& motion);

// Follows the backbone to the amplitude. The system's damping is left out. Errors: kContent for a
// mode that does not exist, an amplitude that is not positive, or a constant force beyond a static
// instability; kSolver if no motion is found near rest, as where two frequencies are equal.
Result<MotionCurve> backbone_curve(const VibratingSystem& system, const BackboneRequest& request,
                                   const CurveOptions& options);

}  // namespace tremolo
