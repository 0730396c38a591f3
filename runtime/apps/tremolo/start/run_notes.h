// Warnings about a run, known before it begins: printed, and listed in the reports as `notes`.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/body.h"

namespace tremolo {

// The largest h^2 omega^2 of the explicit part of a splitting or explicit method at q: of the
// tangent's block of the low rows; for `imexv-linear`, whose kick has all nonlinear terms, of the
// whole tangent minus Lambda of the high rows. Above 4 that part is unstable. 0: nothing explicit.
double explicit_stiffness(const Body& body, const Eigen::VectorXd& q);

// load: the largest reduced force in time besides gravity, r; zero if there is none. Notes:
//   - the explicit part is unstable at the start, or in the equilibrium under load and gravity;
//   - the model has no Gram matrix of its strains, and beta > 0.
std::vector<std::string> notes_before(const Body& body, const Eigen::VectorXd& load);

// The result of one factor. amplitude: the largest displacement over the size, infinite if the run
// ended early; reason: why it did.
struct LoadAttempt {
  double scale = 0.0;
  double amplitude = 0.0;
  std::string reason = {};
};

// scale: zero if none was found; `trouble` says why.
struct LoadScale {
  double scale = 0.0;
  std::string trouble;
};

// Tries factors of four digits, the first one 0.01, until the amplitude is within 1 % of the
// requested one. Errors: those of `attempt`.
Result<LoadScale> search_load_scale(double wanted,
                                    const std::function<Result<LoadAttempt>(double)>& attempt);

}  // namespace tremolo
