// The Fermi-Pasta-Ulam-Tsingou chain of Hairer, Lubich & Wanner, Geometric Numerical Integration,
// I.5: three stiff linear springs joined by soft quartic ones. In the centres x0 and the extensions
// x1 of the stiff springs, scaled so that the masses are 1,
//
//     H = 1/2 |p|^2 + omega^2/2 |x1|^2
//       + 1/4 [ (x0_1 - x1_1)^4 + sum_i (x0_{i+1} - x1_{i+1} - x0_i - x1_i)^4 + (x0_3 + x1_3)^4 ]
//
// The energy I_j = 1/2 (p1_j^2 + omega^2 x1_j^2) of a stiff spring wanders slowly to the next one,
// on a time scale of omega. A method that does not resolve omega may still get that time right, or
// not. V is exactly quartic, so the chain is a Model with q = (x0, x1).
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/integrator.h"

namespace tremolo::known {

inline constexpr double kFputOmega = 50.0;      // rad/s
inline constexpr double kFputDuration = 200.0;  // s

// lambda of x0 is kNoStiffness.
Model::Pointer fput_model();

// x0 = (1,0,0), x1 = (1/omega,0,0), p = (1,0,0,1,0,0).
State fput_start();

// The Hamiltonian above, written out; has no code in common with the model.
double fput_hamiltonian(const State& state);

// I_1, I_2, I_3 at one time.
struct FputEnergies {
  double t = 0.0;
  double i[3] = {};
};

// Result of a run. second, third: the first time at a step's end when I2 > I1 and I3 > I1, s; empty
// if never. lost: time when I left [1/2, 2] of its start, s; a later crossing is no exchange but
// the method's own gain or loss, and does not count. lowest, highest: of I1 + I2 + I3.
// energy_error: max |H - H0| / H0. reached: s; below kFputDuration if the solver gave up, or H
// exceeded ten times its start ("left"). cut_steps: subdivided steps.
struct FputRun {
  std::string method;
  double step = 0.0;
  std::optional<double> second;
  std::optional<double> third;
  std::optional<double> lost;
  double lowest = 0.0;
  double highest = 0.0;
  double energy_error = 0.0;
  double reached = 0.0;
  long cut_steps = 0;
  std::string failure;               // empty, "solver gave up", "energy bound left"
  std::vector<FputEnergies> series;  // every `every` steps; empty for every = 0
};

// step: s. The splitting methods take x0 explicitly, x1 implicitly. Throws a Failure as
// make_integrator.
FputRun run_fput(std::string_view method, double step, long every = 0);

}  // namespace tremolo::known
