// Time and memory of the stages on each rank.
#pragma once

#include <string>
#include <vector>

#include "common/stage_log.h"

namespace tremolo {

// One row for each stage that all ranks executed, in order, with one entry a rank; s and bytes.
struct RankTable {
  struct Row {
    std::string stage;
    std::vector<double> seconds, cpu_seconds, peak_bytes;
  };
  std::vector<Row> rows;
};

// Returns the table, complete on rank 0 only. Collective; the logs must hold the same stages apart
// from those that rank 0 executed alone.
RankTable gather_stages(const StageLog& log);

// Returns the table as text: processor seconds and peak megabytes of each rank.
std::string table_text(const RankTable& table);

}  // namespace tremolo
