// Loads in time: the shapes that a force may have, for bodies and for the unreduced solid
// (docs/reference.md, "Loads in time").
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace tremolo {

enum class SignalKind { kNone, kImpulse, kSquare, kSine, kConstant, kTable };

// Values at times, straight lines between them, zero before the first time and after the last
// one. A time that occurs twice is a jump. times: s, ascending, at least two, each at most twice;
// values: dimensionless, as many. All finite.
struct SignalTable {
  std::vector<double> times;
  std::vector<double> values;
};

// s(t), dimensionless, of height 1 between `start` and `start + duration` (s) and zero elsewhere;
// kSine is sin(2 pi frequency (t - start)) there, kTable the table's value at t - start, whose
// times take the place of the duration. duration 0 means the usual one: 3 ms for an impulse (the
// thesis's; its step), 0.3 s for a square, for ever for sine and constant.
struct Signal {
  SignalKind kind = SignalKind::kNone;
  double start = 0.0;
  double duration = 0.0;
  double frequency = 1.0;              // Hz
  const SignalTable* table = nullptr;  // of kTable; not owned: it must outlive all that has it
};

// Why a table is none; empty if it is one.
std::string table_problem(const SignalTable& table);

// "none", "impulse", "square", "sine", "constant"; kUsage with the list otherwise.
Result<Signal> parse_signal(std::string_view name);

// Time after which the signal is zero for ever, s; infinity if it lasts, `start` for kNone.
double signal_end(const Signal& signal);

// The signal over one step, dimensionless.
struct StepSignal {
  double start = 0.0;    // limit from inside at the step's beginning
  double average = 0.0;  // (1/h) times the integral over the step
  double end = 0.0;      // limit from inside at the step's end
};

// The step [time, time + step]. A jump within 1e-9 step of an end counts as at that end.
StepSignal sample_signal(const Signal& signal, double time, double step);

}  // namespace tremolo
