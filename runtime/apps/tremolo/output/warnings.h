// Warnings of a run: on stderr as they are reported, and under `warnings` in its JSON.
#pragma once

#include <string>
#include <vector>

#include "runtime/integrator.h"

namespace tremolo {

using Warnings = std::vector<std::string>;

// Prints "  warning: TEXT" for each one.
void print_warnings(const Warnings& warnings);

// Steps a period of a mode that a run should make. A sine that is seen so often is read 1.2 % too
// low at most, 1 - cos(pi/20), and midpoint, avf and Newmark's method, with (2 pi/20)^2/12, have
// its frequency 0.8 % too low.
inline constexpr double kStepsAPeriod = 20.0;

// The longest step, s, that resolves a mode's period. frequency: Hz, above 0.
double resolving_step(double frequency);

// The warning about a longer step; empty for a shorter one. whose: put before "first mode", such as
// "the " or "body 'x': its ". flag: the flag for a shorter step, "--step ".
std::string step_warning(double frequency, double step, const std::string& whose,
                         const std::string& flag);

// "28 times slower than real time", of simulated seconds over seconds of computing; empty where
// that is not known.
std::string pace_text(double factor);

// The end of an orbit: its exit code and, if it ended early, the reason. exit_code: 0; 4 if the
// solver gave up; 5 if the energy bound was left (as `tremolo run`).
struct Ending {
  int exit_code = 0;
  std::string reason;

  bool finished() const { return exit_code == 0; }
  void solver_gave_up(const StepReport& step);
  void bound_left();
};

}  // namespace tremolo
