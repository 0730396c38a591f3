// The frequency that a method gives a linear, undamped mode, in closed form.
#pragma once

#include <optional>
#include <string_view>

#include "runtime/integrator.h"

namespace tremolo {

// Phase angle by which the mode of angle z = h omega rotates in a step of the method, rad; z would
// be exact. Methods that split take z < 2 safety as explicit. nullopt: an explicit method beyond
// its limit of stability, or an unknown name. linear: of a linear model, on which ep4 is exact.
//
//     avf, midpoint                 2 atan(z/2)
//     ep2, ep4                      2 atan(z/(2 N)), N the weight of inertia_filter.h at z/2
//     newmark (gamma = 1/2)         acos(1 - z^2/(2 + 2 beta z^2))
//     verlet, imexv's explicit half acos(1 - z^2/2);  its implicit half as midpoint
//     verlet4                       acos of half the trace of its step
//     Euler's, rk2, rk4             the argument of 1 + i z, continued to (i z)^2/2 and (i z)^4/24
std::optional<double> step_angle(std::string_view method, double z,
                                 const IntegratorOptions& options, bool linear = false);

// The relative error of the mode's frequency, |step_angle/z - 1|; infinite where that is nullopt.
double frequency_error(std::string_view method, double z, const IntegratorOptions& options,
                       bool linear = false);

}  // namespace tremolo
