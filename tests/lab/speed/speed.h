// Speed: the cost of each part, compared with the textbook method and with the machine's limits.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "tests/lab/bench/options.h"
#include "tests/lab/report/report.h"

namespace tremolo::bench {

// One measured figure. value, baseline and limit have one unit; one that was not measured or does
// not apply is not-a-number or empty.
struct SpeedRow {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::string what;             // "force + tangent + energy, r = 30"
  double value = kNone;         // of one operation
  std::string unit = "us";      // us, s, bytes
  double baseline = kNone;      // the textbook method, measured alternately in the same run
  double bytes = kNone;         // that one operation uses
  double operations = kNone;    // floating-point operations of it, a multiply-add counts two
  double limit = kNone;         // the least that memory or arithmetic of this machine allows
  std::string limited_by = {};  // "FMA peak", "L2 bandwidth", ...
  std::string note = {};

  double ratio() const { return value / baseline; }
};

// A row in microseconds of an operation of `seconds`, compared with `baseline` seconds.
inline SpeedRow microseconds(std::string what, double seconds, double baseline = SpeedRow::kNone,
                             std::string note = {}) {
  return {.what = std::move(what),
          .value = 1e6 * seconds,
          .baseline = 1e6 * baseline,
          .note = std::move(note)};
}

struct SpeedSection {
  std::string title;
  std::string text;  // the measured quantity and the method
  std::vector<SpeedRow> rows;
  std::vector<Criterion> criteria;
};

// The peak rates of one core of this machine, measured in loops that do nothing else.
struct MachineProbe {
  std::string vectors;            // the kernels' instructions: "AVX-512", "AVX2", "plain"
  double gflops = 0.0;            // double multiply-adds, two operations each, 1e9/s
  double gflops_f32 = 0.0;        // the same in float
  double l2_bandwidth = 0.0;      // read, working set 512 KiB, 1e9 bytes/s
  double l3_bandwidth = 0.0;      // read, working set 6 MiB
  double memory_bandwidth = 0.0;  // read, working set 256 MiB
};
MachineProbe probe_machine();

// Smallest processor time of one call of each, s: `calls` calls per window, `windows` windows. They
// take turns, so that a noisy period affects all.
using Work = std::function<void()>;
std::vector<double> by_turns(const std::vector<Work>& works, int calls, int windows);

// The sections, in the order of the report. They throw a Failure: of loading a model, of a step.
SpeedSection measure_kernel_speed(const Options& options, const MachineProbe& probe);
SpeedSection measure_step_speed(const Options& options, const MachineProbe& probe);
SpeedSection measure_world_speed(const Options& options, const MachineProbe& probe);
SpeedSection measure_surface_speed(const Options& options, const MachineProbe& probe);
SpeedSection measure_frames_speed(const Options& options, const MachineProbe& probe);
SpeedSection measure_hand_speed(const Options& options, const MachineProbe& probe);
SpeedSection measure_savings_speed(const Options& options, const MachineProbe& probe);

// All sections.
struct Speed {
  MachineProbe machine;
  std::vector<SpeedSection> sections;
};

// All sections, or the one that --only names: "hand", "frames". Takes two or three minutes and
// prints each row on stderr. Throws as the sections do.
Speed measure_speed(const Options& options);

// One section, with speed.csv. Throws a Failure (kSystem).
void report_speed(const Speed& speed, Report& report);

std::vector<Criterion> speed_criteria(const Speed& speed);
nlohmann::ordered_json to_json(const Speed& speed);

}  // namespace tremolo::bench
