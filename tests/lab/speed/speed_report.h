// All sections of speed.h, one after the other, and how they are shown.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/lab/report/report.h"
#include "tests/lab/speed/speed.h"

namespace tremolo::bench {

struct Speed {
  MachineProbe machine;
  std::vector<SpeedSection> sections;
};

// Takes a minute or two; a line a row on stderr. Throws as the sections do.
Speed measure_speed(const Options& options);

// One section, with speed.csv. Throws a Failure (kSystem).
void report_speed(const Speed& speed, Report& report);

std::vector<Criterion> speed_criteria(const Speed& speed);
nlohmann::ordered_json to_json(const Speed& speed);

}  // namespace tremolo::bench
