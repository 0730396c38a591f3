// Warnings about a run, known before it begins: printed, and listed in the reports as `notes`.
#pragma once

#include <string>
#include <vector>

#include "runtime/body.h"

namespace tremolo {

// The largest h^2 omega^2 of what a splitting or explicit method takes explicitly at q: of the
// tangent's block of the low rows; of `imexv-linear`, which kicks all that is not linear, of the
// whole tangent less Lambda of the high rows. Above 4 that half is unstable. 0: nothing explicit.
double explicit_stiffness(const Body& body, const Eigen::VectorXd& q);

// load: the largest reduced force in time besides gravity, r; zero if there is none. Notes tell
//   - where the body begins, or its load and gravity put it, the explicit half is unstable;
//   - that the model has no Gram matrix of its strains, and beta > 0.
std::vector<std::string> notes_before(const Body& body, const Eigen::VectorXd& load);

}  // namespace tremolo
