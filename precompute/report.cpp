#include "precompute/report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "common/units.h"
#include "formats/file/standard_streams.h"
#include "precompute/target_error.h"

namespace tremolo {
namespace {

using Json = nlohmann::ordered_json;

Json stages_json(const StageLog& log) {
  Json stages = Json::array();
  for (const StageRecord& stage : log.records())
    stages.push_back({{"name", stage.name},
                      {"seconds", stage.seconds},
                      {"cpu_seconds", stage.cpu_seconds},
                      {"limit_seconds", stage.limit_seconds},
                      {"limit_reason", stage.limit_reason},
                      {"peak_bytes", stage.peak_bytes},
                      {"detail", stage.detail}});
  return stages;
}

Json ranks_json(const RankTable& ranks) {
  Json rows = Json::array();
  for (const RankTable::Row& row : ranks.rows)
    rows.push_back({{"stage", row.stage},
                    {"seconds", row.seconds},
                    {"cpu_seconds", row.cpu_seconds},
                    {"peak_bytes", row.peak_bytes}});
  return rows;
}

// Returns one material or several, as stored in the provenance.
Json materials_json(const Json& provenance) {
  Json materials = Json::array();
  if (provenance.contains("materials")) materials = provenance["materials"];
  if (provenance.contains("material")) materials.push_back(provenance["material"]);
  return materials;
}

// Returns the largest stable step of an explicit method, s.
double explicit_step_limit(const BasisData& data) {
  return 2.0 / std::sqrt(data.lambda[data.lambda.size() - 1]);
}

}  // namespace

void print_result(const PrecomputeResult& result, const StageLog& log, const RankTable& ranks) {
  const BasisData& data = result.data;
  const std::size_t r = data.lambda.size();
  Json frequencies = Json::array();
  for (double value : data.lambda) frequencies.push_back(hertz(value));
  std::vector<double> cut(data.singular_values.begin() +
                              static_cast<std::ptrdiff_t>(std::min(r, data.singular_values.size())),
                          data.singular_values.end());
  const Json provenance = Json::parse(data.provenance);
  const Json json = {{"order", result.problem.order},
                     {"elements", data.tetrahedron_count},
                     {"dofs", 3 * result.map.nodes()},
                     {"n", data.vertex_count},
                     {"m", data.tetrahedron_count},
                     {"r", r},
                     {"linear_modes", data.linear_mode_count},
                     {"rigid_modes", data.rigid_mode_count},
                     {"frequencies_hz", frequencies},
                     {"explicit_step_limit_s", explicit_step_limit(data)},
                     {"total_mass_kg", data.total_mass},
                     {"materials", materials_json(provenance)},
                     {"point_masses", provenance.value("point_masses", Json::array())},
                     {"factorisation", result.findings.factorisation},
                     {"mode_residuals", result.findings.mode_residuals},
                     {"derivative_residual", result.findings.derivative_residual},
                     {"inertia_count", result.findings.inertia_count},
                     {"certified_by_inertia", result.findings.certified},
                     {"mass_orthonormality_error", result.findings.orthonormality_error},
                     {"polynomial_error", result.findings.polynomial_error},
                     {"cut_singular_values", cut},
                     {"locking", to_json(result.findings.locking)},
                     {"target_error", target_json(result.findings.target)},
                     {"error_budget", budget_json(result.findings.budget)},
                     {"encoding", provenance.value("encoding", Json{{"name", "full"}})},
                     {"notes", result.problem.notes},
                     {"ranks", mpi_ranks()},
                     {"stages", stages_json(log)},
                     {"stages_of_ranks", ranks_json(ranks)}};
  print_json(json);
}

void print_spectrum(const BasisData& data) {
  std::fprintf(stderr, "  frequencies ");
  for (double value : data.lambda) std::fprintf(stderr, " %.4g", hertz(value));
  std::fprintf(stderr, " Hz\n  explicit methods are stable below a step of %.4g s\n",
               explicit_step_limit(data));
}

void print_total(const StageLog& log, const RankTable& ranks) {
  double seconds = 0, cpu_seconds = 0;
  std::uint64_t peak = 0;
  for (const StageRecord& stage : log.records()) {
    seconds += stage.seconds;
    cpu_seconds += stage.cpu_seconds;
    peak = std::max(peak, stage.peak_bytes);
  }
  std::fprintf(stderr, "  %-12s %7.2f s %7.2f s cpu %6.0f MB\n", "total", seconds, cpu_seconds,
               static_cast<double>(peak) / 1e6);
  if (mpi_ranks() > 1)
    std::fprintf(stderr, "  processor time and peak memory of each rank\n%s\n",
                 table_text(ranks).c_str());
}

}  // namespace tremolo
