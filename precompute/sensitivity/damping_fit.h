// Damping from measured ratios and decays: alpha and beta by least squares, and the ratios as they
// are for --damping-ratio.
//
// What was measured is compared, a ratio or the time of a decay, since only its error is symmetric.
// Where the deviations are not known they are equal fractions of the fitted values, and the fit is
// repeated with them until it no longer changes: fractions of the measured values would favour
// those measured low.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "precompute/sensitivity/measurements.h"

namespace tremolo {

// Rayleigh damping zeta = alpha/(2 omega) + beta omega/2, neither negative.
struct DampingFit {
  Uncertain alpha, beta;     // 1/s, s; a deviation is 0 where it is not known
  double correlation = 0.0;  // of the two; 0 where one of them is zero
  double chi_squared = 0.0;  // with the deviations; if not known, of equal fractions
  int freedom = 0;           // ratios less constants that are not zero
  // The measured ratios as a list by mode, linear in frequency between measured modes.
  std::string ratios;
};

// modes: of every row, from 0; hertz: of the model's modes. Nothing without a measured ratio.
std::optional<DampingFit> fit_damping(const Measurements& measured, const std::vector<int>& modes,
                                      const Eigen::VectorXd& hertz);

}  // namespace tremolo
