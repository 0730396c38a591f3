#include "common/load_signal.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace tremolo {
namespace {

constexpr double kImpulseDuration = 3e-3;  // s, one step of the thesis
constexpr double kSquareDuration = 0.3;    // s
constexpr double kSnap = 1e-9;             // in steps: rounding of k*h against a jump's time
constexpr double kForever = std::numeric_limits<double>::infinity();

double snapped(double value, double time, double end, double slack) {
  if (std::abs(value - time) <= slack) return time;
  if (std::abs(value - end) <= slack) return end;
  return value;
}

// The part of [begin, finish] with the signal on it: its shape is smooth there.
StepSignal sample_sine(const Signal& signal, double begin, double finish, double step) {
  const double rate = 2.0 * std::numbers::pi * signal.frequency;
  const double middle = 0.5 * (begin + finish) - signal.start;
  const double half = 0.5 * (finish - begin);
  // The integral (cos a - cos b)/rate as a product of sines: no cancellation for short steps.
  const double integral =
      rate == 0.0 ? 0.0 : 2.0 * std::sin(rate * middle) * std::sin(rate * half) / rate;
  return {std::sin(rate * (begin - signal.start)), integral / step,
          std::sin(rate * (finish - signal.start))};
}

// The table's straight line between the times k and k + 1, at `time` on it.
double table_line(const SignalTable& table, std::size_t k, double time) {
  const double t0 = table.times[k], t1 = table.times[k + 1];
  const double v0 = table.values[k], v1 = table.values[k + 1];
  // Exact at its ends: what follows must not be taken for a jump.
  return time < t1 ? v0 + (v1 - v0) * ((time - t0) / (t1 - t0)) : v1;
}

// Returns the table's time that is within `slack` of `time`, else `time`.
double table_snapped(const SignalTable& table, double time, double slack) {
  const auto near = std::lower_bound(table.times.begin(), table.times.end(), time - slack);
  return near != table.times.end() && *near <= time + slack ? *near : time;
}

// Times are the table's own. Each piece between two times is a line: its average is that of its
// ends.
StepSignal sample_table(const SignalTable& table, double time, double step) {
  const double slack = kSnap * step;
  const std::vector<double>& times = table.times;
  const double begin = table_snapped(table, time, slack);
  const double end = table_snapped(table, time + step, slack);
  const double first = std::max(begin, times.front()), last = std::min(end, times.back());
  if (!(first < last)) return {};
  // From the last time at or before `first`, so that a jump there has happened.
  std::size_t k = std::upper_bound(times.begin(), times.end(), first) - times.begin() - 1;
  StepSignal sample;
  sample.start = begin < first ? 0.0 : table_line(table, k, first);
  double area = 0.0, left = table_line(table, k, first), right = 0.0;
  bool jump = begin < first && left != 0.0;
  for (double at = first; at < last; ++k) {
    const double next = std::min(times[k + 1], last);
    const double value = table_line(table, k, at);
    jump = jump || (at > first && value != left);
    right = table_line(table, k, next);
    area += (next - at) * 0.5 * (value + right);
    left = right;
    at = next;
  }
  jump = jump || (last < end && right != 0.0);
  sample.end = last < end ? 0.0 : right;
  sample.average = area / step;
  if (jump) sample.start = sample.end = sample.average;
  return sample;
}

}  // namespace

std::string table_problem(const SignalTable& table) {
  const std::vector<double>& times = table.times;
  if (times.size() < 2 || times.size() != table.values.size()) return "it has no two moments";
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (!std::isfinite(times[k]) || !std::isfinite(table.values[k]))
      return "moment " + std::to_string(k + 1) + " is not finite";
    if (k > 0 && times[k] < times[k - 1])
      return "moment " + std::to_string(k + 1) + " is earlier than the one before it";
    if (k > 1 && times[k] == times[k - 2])
      return "moment " + std::to_string(k + 1) + " stands three times: a jump has two values";
  }
  if (!(times.front() < times.back())) return "it lasts no time";
  return {};
}

Result<Signal> parse_signal(std::string_view name) {
  constexpr std::pair<std::string_view, SignalKind> kNames[] = {
      {"none", SignalKind::kNone},
      {"impulse", SignalKind::kImpulse},
      {"square", SignalKind::kSquare},
      {"sine", SignalKind::kSine},
      {"constant", SignalKind::kConstant}};
  for (const auto& [known, kind] : kNames)
    if (name == known) return Signal{.kind = kind};
  return Error{ErrorKind::kUsage, "unknown load '" + std::string(name) +
                                      "'; known: none, impulse, square, sine, constant"};
}

double signal_end(const Signal& signal) {
  if (signal.kind == SignalKind::kNone) return signal.start;
  if (signal.kind == SignalKind::kTable)
    return signal.start + (signal.table ? signal.table->times.back() : 0.0);
  if (signal.duration > 0.0) return signal.start + signal.duration;
  if (signal.kind == SignalKind::kImpulse) return signal.start + kImpulseDuration;
  if (signal.kind == SignalKind::kSquare) return signal.start + kSquareDuration;
  return kForever;
}

StepSignal sample_signal(const Signal& signal, double time, double step) {
  if (signal.kind == SignalKind::kNone) return {};
  if (signal.kind == SignalKind::kTable)
    return signal.table ? sample_table(*signal.table, time - signal.start, step) : StepSignal{};
  const double end = time + step;
  const double slack = kSnap * step;
  const double on = snapped(signal.start, time, end, slack);
  const double off = snapped(signal_end(signal), time, end, slack);
  const double begin = std::max(on, time);
  const double finish = std::min(off, end);
  if (!(begin < finish)) return {};
  StepSignal sample{1.0, 1.0, 1.0};
  const bool whole = begin == time && finish == end;
  if (signal.kind == SignalKind::kSine)
    sample = sample_sine(signal, begin, finish, step);
  else if (!whole)
    sample.average = (finish - begin) / step;
  // A sine starts from zero: a kink, no jump. Every other edge inside the step is a jump.
  const bool kink_only = signal.kind == SignalKind::kSine && finish == end;
  if (!whole && !kink_only) sample.start = sample.end = sample.average;
  return sample;
}

}  // namespace tremolo
