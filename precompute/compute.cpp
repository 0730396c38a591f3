#include <cstdio>

#include "formats/basis/basis_writer.h"
#include "formats/file/standard_streams.h"
#include "precompute/checkpoint/checkpoint.h"
#include "precompute/command.h"
#include "precompute/problem/model_geometry.h"
#include "precompute/problem/preview.h"
#include "precompute/ranks/rank_agreement.h"
#include "precompute/ranks/rank_table.h"
#include "precompute/ranks/row_gather.h"
#include "precompute/ranks/session.h"
#include "precompute/report.h"
#include "precompute/target_error.h"

namespace tremolo {
namespace {

void find_encoding_error(PrecomputeResult& result, StageLog& log) {
  log.begin("encoding");
  const EncodingError error = unwrap(compact_error(result.data));
  result.findings.encoding_error = error;
  char detail[200];
  std::snprintf(detail, sizeof(detail),
                "compact: displacement off by %.1e of the size under the default load, by %.1e at "
                "most; force by %.1e of the load",
                error.displacement, error.displacement_bound, error.force);
  log.end(detail);
}

// Writes the files on rank 0, while other ranks send their rows.
void write_result(const PrecomputeRequest& request, const LoadedProblem& loaded,
                  PrecomputeResult& result, bool rows_are_here, StageLog& log) {
  const OutputRequest& output = request.output;
  if (output.encoding == BasisEncoding::kCompact) find_encoding_error(result, log);
  const auto& render = result.data.render;
  const bool on_bones = render && render->surface.rig != nullptr;
  if (output.keep_elements || on_bones) add_elements(loaded.problem, result.data);
  result.data.provenance = provenance_json(request, loaded.problem, result);
  log.begin("file");
  Status written = rows_are_here
                       ? write_basis(output.basis, result.data, output.encoding)
                       : write_basis(output.basis, result.data,
                                     gathered_rows(spread(loaded, result.rows), result.data));
  if (!written && request.checkpoint.keep)
    written.error().message += "; the stages are kept: --resume continues from them";
  unwrap(std::move(written));
  log.end(output.basis);
  write_vtu(output.modes_vtu, loaded.problem.mesh, result.data, log);
}

void measure_budget(const PrecomputeRequest& request, const Problem& problem,
                    PrecomputeResult& result, StageLog& log) {
  if (!request.output.error_budget) return;
  log.begin("budget");
  result.findings.budget = measure_budget(
      BudgetSubject{problem, request.solid.elements.mass, result.data, result.rows,
                    request.output.basis, request.solid.threads, request.solve.memory});
  for (const std::string& reason : result.findings.budget->reasons)
    log.note("not measured, " + reason);
  log.end(describe(*result.findings.budget));
}

// Sends the rows of a rank other than 0, unless all rows have been collected.
void serve_first_rank(const LoadedProblem& loaded, const PrecomputeResult& result,
                      bool rows_are_here, StageLog& log) {
  log.begin("file");
  if (!rows_are_here) serve_rows(spread(loaded, result.rows), result.data);
  log.end("");
  gather_stages(log);
}

// Gathers the response at the places on rank 0. Collective.
LocalResponse collect_response(const LoadedProblem& loaded, const PrecomputeResult& result) {
  LocalResponse response;
  if (loaded.response_places.empty()) return response;
  GatheredRows rows = gather_rows(spread(loaded, result.response), result.data);
  for (const ResponsePlace& place : loaded.response_places) response.at.push_back(place.at);
  response.surface = std::move(rows.surface);
  response.render = std::move(rows.render);
  response.interior = std::move(rows.interior);
  return response;
}

}  // namespace

void compute(const PrecomputeRequest& request) {
  StageLog log(mpi_rank() != 0);
  const LoadedProblem loaded = load_mesh(request, log);
  if (mpi_rank() == 0) write_preview(request.output.preview, loaded.problem);
  PrecomputeResult result = request.basis.target_error ? precompute_to_target(request, loaded, log)
                                                       : run_precompute(request, loaded, log);
  // These need all rows at once.
  const bool collect =
      request.output.encoding == BasisEncoding::kCompact || !request.output.modes_vtu.empty();
  if (collect) collect_rows(spread(loaded, result.rows), result.data);
  result.data.response = collect_response(loaded, result);
  if (mpi_rank() != 0) return serve_first_rank(loaded, result, collect, log);
  try {
    write_result(request, loaded, result, collect, log);
    measure_budget(request, loaded.problem, result, log);
  } catch (...) {
    if (mpi_ranks() > 1) stop_all_ranks(current_error());
    throw;
  }
  remove_checkpoint(request.checkpoint, log);
  const RankTable ranks = gather_stages(log);
  print_total(log, ranks);
  print_spectrum(result.data);
  // Stages read from a checkpoint have not read their solver's options.
  if (!result.findings.resumed) warn_of_unused_options();
  if (request.output.json) print_result(loaded, result, log, ranks);
  unwrap(flush_standard_output());
}

}  // namespace tremolo
