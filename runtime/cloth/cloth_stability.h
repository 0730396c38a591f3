// The largest step for which a method is stable on a cloth.
#pragma once

#include <string_view>

#include <Eigen/Core>

#include "runtime/cloth/cloth_model.h"

namespace tremolo {

// The largest h omega for which the method `name` keeps x'' = -omega^2 x - 2 zeta omega x' from
// growing; infinity for a method without a limit.
double damped_stability_number(std::string_view name, double zeta);

// The largest stable step, s, for the sheet's largest frequency at x with the dampers of its
// springs: the smaller of the steps for the most and the least damped kind of spring. Infinity for
// methods without a limit. The frequencies of a loaded or folded sheet are slightly higher.
double stable_step(std::string_view name, const ClothModel& model, const Eigen::VectorXd& x);

}  // namespace tremolo
