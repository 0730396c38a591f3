#include "precompute/ranks/rank_table.h"

#include <algorithm>

#include "common/text.h"
#include "precompute/system/petsc.h"

namespace tremolo {
namespace {

// Stages that every rank executes unless they are skipped.
constexpr const char* kShared[] = {"mesh",        "matrices", "modes",        "derivatives",
                                   "certificate", "basis",    "coefficients", "file"};

}  // namespace

RankTable gather_stages(const StageLog& log) {
  constexpr std::size_t kNumbers = 3;
  constexpr std::size_t kStages = std::size(kShared);
  std::vector<double> local_values(kNumbers * kStages, -1.0);
  for (std::size_t i = 0; i < kStages; ++i)
    for (const StageRecord& record : log.records())
      if (record.name == kShared[i]) {
        local_values[kNumbers * i] = record.seconds;
        local_values[kNumbers * i + 1] = record.cpu_seconds;
        local_values[kNumbers * i + 2] = static_cast<double>(record.peak_bytes);
      }
  const std::size_t ranks = mpi_ranks();
  std::vector<double> all(local_values.size() * ranks);
  MPI_Gather(local_values.data(), static_cast<int>(local_values.size()), MPI_DOUBLE, all.data(),
             static_cast<int>(local_values.size()), MPI_DOUBLE, 0, PETSC_COMM_WORLD);
  RankTable table;
  for (std::size_t i = 0; i < kStages; ++i) {
    if (local_values[kNumbers * i] < 0) continue;
    RankTable::Row row{kShared[i], {}, {}, {}};
    for (std::size_t rank = 0; rank < ranks; ++rank) {
      const double* numbers = all.data() + rank * local_values.size() + kNumbers * i;
      row.seconds.push_back(std::max(0.0, numbers[0]));
      row.cpu_seconds.push_back(std::max(0.0, numbers[1]));
      row.peak_bytes.push_back(std::max(0.0, numbers[2]));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::string table_text(const RankTable& table) {
  if (table.rows.empty()) return "";
  std::string lines = "  rank        ";
  for (std::size_t rank = 0; rank < table.rows.front().seconds.size(); ++rank)
    lines += text("%18zu", rank);
  for (const RankTable::Row& row : table.rows) {
    lines += text("\n  %-12s", row.stage.c_str());
    for (std::size_t rank = 0; rank < row.seconds.size(); ++rank)
      lines += text("%8.2f s %5.0f MB", row.cpu_seconds[rank], 1e-6 * row.peak_bytes[rank]);
  }
  return lines;
}

}  // namespace tremolo
