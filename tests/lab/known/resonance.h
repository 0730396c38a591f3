// Linear resonance: what a large step does to a fast oscillator that is pulled by a slow force,
//
//     q'' = -(omega^2 + k) q,    k << omega^2.
//
// The impulse method (r-RESPA, Verlet-I) takes the fast part exactly and kicks with the slow one:
//
//     half kick  p <- p - (h/2) k q,   exact rotation by h omega,   half kick
//
// Its map has the trace 2 cos(h omega) - (h k/omega) sin(h omega), of modulus above 2 just below
// every h omega = n pi: the step resonates with the fast oscillation. A method whose fast part is
// taken by the midpoint rule rotates by less than pi a step, for any h, and cannot.
//
// The others here are the integrators themselves. In a Model the quadratic part of V is one
// diagonal, which the splitting methods put wholly on one side. So k comes from the quartic part:
//
//     V = 1/2 omega^2 q^2 + 1/2 k s^2 q^2
//
// with a slow coordinate s that is at 1. Linearised there q obeys the equation above, s stays;
// s is explicit and q implicit, and `imexv-linear` kicks with the k and takes the omega^2 by the
// midpoint rule. One step from q = 1e-6 and one from p = 1e-6 give its 2 x 2 matrix; what is
// neglected is of relative size 1e-12.
#pragma once

#include <optional>
#include <string_view>

#include <Eigen/Core>

namespace tremolo::known {

inline constexpr double kResonanceSlow = 0.03;  // k, with omega = 1

// The larger of the moduli of the two eigenvalues.
double spectral_radius(const Eigen::Matrix2d& map);

// One step of r-RESPA on (q, p), omega = 1: the closed form. h: dimensionless, h omega.
Eigen::Matrix2d respa_map(double h, double k);

// One step of the named integrator on (q, p), omega = 1, from the model above. Empty if a solve
// fails. Throws a Failure as make_integrator.
std::optional<Eigen::Matrix2d> linear_map(std::string_view method, double h, double k);

}  // namespace tremolo::known
