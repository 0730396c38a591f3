// Loads in time: the shapes that a force may have, for bodies and for the unreduced solid
// (docs/reference.md, "Loads in time").
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace tremolo {

enum class SignalKind { kNone, kImpulse, kSquare, kSine, kConstant, kTable, kChirp, kRamp };

// Values at times, straight lines between them, zero before the first time and after the last
// one. A time that occurs twice is a jump. times: s, ascending, at least two, each at most twice;
// values: dimensionless, as many. All finite.
struct SignalTable {
  std::vector<double> times;
  std::vector<double> values;
};

// s(t), dimensionless, of height 1 between `start` and `start + duration` (s) and zero elsewhere.
// With t from `start` on: kSine is sin(2 pi frequency t); kChirp is sin(2 pi (frequency t +
// (last_frequency - frequency) t^2 / (2 duration))), whose frequency changes linearly; kRamp rises
// linearly from 0 to 1 and stays at 1; kTable is the table's value at t, whose times replace the
// duration. duration 0 means the default: 3 ms for an impulse (the thesis's step), 0.3 s for a
// square, 1 s for chirp and ramp, unlimited for sine and constant.
struct Signal {
  SignalKind kind = SignalKind::kNone;
  double start = 0.0;
  double duration = 0.0;
  double frequency = 1.0;              // Hz
  const SignalTable* table = nullptr;  // of kTable; not owned: it must outlive all that has it
  double last_frequency = 10.0;        // Hz, of kChirp
};

// A user's numbers for a signal; missing ones keep the default.
struct SignalShape {
  std::optional<double> frequency;  // Hz, of a sine
  std::string sweep;                // "F1,F2" in Hz, of a chirp
  std::optional<double> duration;   // s
};

// Applies the shape to the signal. Errors: kUsage for a number that does not apply to this kind of
// signal, or a sweep that is not two numbers; kContent for values that are not positive and finite.
Status shape_signal(const SignalShape& shape, Signal& signal);

// The reason why a table is not valid; empty if it is.
std::string table_problem(const SignalTable& table);

// "none", "impulse", "square", "sine", "chirp", "ramp", "constant"; kUsage with the list otherwise.
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
