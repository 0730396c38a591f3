// All sections of speed.h, one after the other, and how they are shown.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/lab/report/page.h"
#include "tests/lab/speed/speed.h"

namespace tremolo::bench {

struct Speed {
  MachineProbe machine;
  std::vector<SpeedSection> sections;
};

// Takes a minute or two; a line a row on stderr. Errors: of the sections.
Result<Speed> measure_speed(const Options& options);

// One section of the page; speed.csv into the directory, which exists. Errors: kSystem.
Status report_speed(const Speed& speed, const std::string& directory, Page& page);

std::vector<Criterion> speed_criteria(const Speed& speed);
nlohmann::ordered_json to_json(const Speed& speed);

}  // namespace tremolo::bench
