// How the stages' time and memory split over the ranks.
#pragma once

#include <string>
#include <vector>

#include "common/stage_log.h"

namespace tremolo {

// One row a stage that all ranks went through, in order; one entry a rank.
struct RankTable {
  struct Row {
    std::string stage;
    std::vector<double> seconds, cpu_seconds, peak_bytes;
  };
  std::vector<Row> rows;
};

// Complete on rank 0. All ranks together, with the same stages in their logs but for what rank 0
// did alone.
RankTable gather_stages(const StageLog& log);

// For the terminal: peak megabytes and processor seconds of each rank.
std::string table_text(const RankTable& table);

}  // namespace tremolo
