#include "common/load_signal.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "common/text.h"

namespace tremolo {
namespace {

constexpr double kImpulseDuration = 3e-3;  // s, one step of the thesis
constexpr double kSquareDuration = 0.3;    // s
constexpr double kSlowDuration = 1.0;      // s, of chirp and ramp
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

// The phase of a chirp at t after its start, rad.
double chirp_phase(const Signal& signal, double t) {
  const double rate =
      (signal.last_frequency - signal.frequency) / (signal_end(signal) - signal.start);
  return 2.0 * std::numbers::pi * t * (signal.frequency + 0.5 * rate * t);
}

// A chirp's integral is one of Fresnel's: with eight Gauss points on pieces of at most two radians
// its error is below rounding. Steps of more than 2 048 pieces contain more than 600 waves, whose
// effect on the motion vanishes.
StepSignal sample_chirp(const Signal& signal, double begin, double finish, double step) {
  constexpr std::array<double, 4> kPoints = {0.1834346424956498, 0.5255324099163290,
                                             0.7966664774136267, 0.9602898564975363};
  constexpr std::array<double, 4> kWeights = {0.3626837833783620, 0.3137066458778873,
                                              0.2223810344533745, 0.1012285362903763};
  const double first = begin - signal.start, last = finish - signal.start;
  const double waves = std::max(signal.frequency, signal.last_frequency) * (last - first);
  const int pieces = 1 + static_cast<int>(std::min(std::numbers::pi * waves, 2047.0));
  const double half = 0.5 * (last - first) / pieces;
  double integral = 0.0;
  for (int piece = 0; piece < pieces; ++piece) {
    const double middle = first + (2 * piece + 1) * half;
    for (std::size_t n = 0; n < kPoints.size(); ++n)
      for (const double side : {-1.0, 1.0})
        integral +=
            half * kWeights[n] * std::sin(chirp_phase(signal, middle + side * half * kPoints[n]));
  }
  return {std::sin(chirp_phase(signal, first)), integral / step,
          std::sin(chirp_phase(signal, last))};
}

// A ramp over a whole step: it may reach its height inside, a kink.
StepSignal sample_ramp(const Signal& signal, double time, double step) {
  const double rise = signal.duration > 0.0 ? signal.duration : kSlowDuration;
  const auto height = [&](double t) { return std::clamp((t - signal.start) / rise, 0.0, 1.0); };
  // The integral of the height up to t.
  const auto area = [&](double t) {
    const double after = t - signal.start;
    if (after <= 0.0) return 0.0;
    return after < rise ? 0.5 * after * after / rise : after - 0.5 * rise;
  };
  const double begin = height(time), end = height(time + step);
  // Within one piece the average is that of the ends, without cancellation.
  const bool straight = time + step <= signal.start || time >= signal.start + rise ||
                        (time >= signal.start && time + step <= signal.start + rise);
  const double average = straight ? 0.5 * (begin + end) : (area(time + step) - area(time)) / step;
  return {begin, average, end};
}

// Linear interpolation in the table between rows k and k + 1, at `time`.
double table_line(const SignalTable& table, std::size_t k, double time) {
  const double t0 = table.times[k], t1 = table.times[k + 1];
  const double v0 = table.values[k], v1 = table.values[k + 1];
  // Exact at its ends, so that rounding does not look like a jump.
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
      {"none", SignalKind::kNone},        {"impulse", SignalKind::kImpulse},
      {"square", SignalKind::kSquare},    {"sine", SignalKind::kSine},
      {"chirp", SignalKind::kChirp},      {"ramp", SignalKind::kRamp},
      {"constant", SignalKind::kConstant}};
  for (const auto& [known, kind] : kNames)
    if (name == known) return Signal{.kind = kind};
  return Error{ErrorKind::kUsage,
               "unknown load '" + std::string(name) +
                   "'; known: none, impulse, square, sine, chirp, ramp, constant"};
}

Status shape_signal(const SignalShape& shape, Signal& signal) {
  const auto positive = [](double value) { return value > 0.0 && std::isfinite(value); };
  const auto refuse = [](const std::string& text) { return Error{ErrorKind::kUsage, text}; };
  if (shape.frequency) {
    if (signal.kind != SignalKind::kSine)
      return refuse("frequency applies only to the load sine; a chirp has a sweep F1,F2");
    if (!positive(*shape.frequency))
      return content_error("the frequency of a load must be positive and finite, Hz");
    signal.frequency = *shape.frequency;
  }
  if (!shape.sweep.empty()) {
    if (signal.kind != SignalKind::kChirp) return refuse("sweep applies only to the load chirp");
    const std::string_view text = shape.sweep;
    const std::size_t comma = std::min(text.find(','), text.size());
    const char* const end = text.data() + text.size();
    const char* const second = comma < text.size() ? text.data() + comma + 1 : end;
    const auto [stop1, error1] = read_decimal(text.data(), text.data() + comma, signal.frequency);
    const auto [stop2, error2] = read_decimal(second, end, signal.last_frequency);
    if (error1 != std::errc{} || stop1 != text.data() + comma || error2 != std::errc{} ||
        stop2 != end)
      return refuse("sweep " + shape.sweep + ": expected F1,F2, two frequencies in Hz");
    if (!positive(signal.frequency) || !positive(signal.last_frequency))
      return content_error("sweep " + shape.sweep +
                           ": frequencies must be positive and finite, Hz");
  }
  if (!shape.duration) return Success{};
  if (signal.kind == SignalKind::kNone || signal.kind == SignalKind::kTable)
    return refuse("load-duration applies only to a load that is not none and has no table");
  if (!positive(*shape.duration))
    return content_error("load-duration must be positive and finite, s");
  signal.duration = *shape.duration;
  return Success{};
}

double signal_end(const Signal& signal) {
  if (signal.kind == SignalKind::kNone) return signal.start;
  if (signal.kind == SignalKind::kTable)
    return signal.start + (signal.table ? signal.table->times.back() : 0.0);
  if (signal.kind == SignalKind::kRamp) return kForever;
  if (signal.duration > 0.0) return signal.start + signal.duration;
  if (signal.kind == SignalKind::kChirp) return signal.start + kSlowDuration;
  if (signal.kind == SignalKind::kImpulse) return signal.start + kImpulseDuration;
  if (signal.kind == SignalKind::kSquare) return signal.start + kSquareDuration;
  return kForever;
}

StepSignal sample_signal(const Signal& signal, double time, double step) {
  if (signal.kind == SignalKind::kNone) return {};
  if (signal.kind == SignalKind::kTable)
    return signal.table ? sample_table(*signal.table, time - signal.start, step) : StepSignal{};
  if (signal.kind == SignalKind::kRamp) return sample_ramp(signal, time, step);
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
  else if (signal.kind == SignalKind::kChirp)
    sample = sample_chirp(signal, begin, finish, step);
  else if (!whole)
    sample.average = (finish - begin) / step;
  // Waves start from zero: a kink, no jump. Every other edge inside the step is a jump.
  const bool wave = signal.kind == SignalKind::kSine || signal.kind == SignalKind::kChirp;
  const bool kink_only = wave && finish == end;
  if (!whole && !kink_only) sample.start = sample.end = sample.average;
  return sample;
}

}  // namespace tremolo
