// Up to which step a method is stable on a cloth.
#pragma once

#include <string_view>

#include <Eigen/Core>

#include "runtime/cloth/cloth_model.h"

namespace tremolo {

// h omega up to which the method `name` keeps x'' = -omega^2 x - 2 zeta omega x' from growing;
// infinity for one that has no limit.
double damped_stability_number(std::string_view name, double zeta);

// The step, s, of the sheet's own largest frequency at x, with the dampers of its springs: the
// smaller one of what the most and the least damped kind of spring allow. Infinity for methods
// without a limit. Frequencies of a sheet under load, and of one that is folded, are a little
// higher.
double stable_step(std::string_view name, const ClothModel& model, const Eigen::VectorXd& x);

}  // namespace tremolo
