#include "precompute/command.h"

#include <algorithm>
#include <cstdio>
#include <iostream>

#include "common/text.h"
#include "formats/basis/basis_writer.h"
#include "formats/basis/selector_reader.h"
#include "formats/file/atomic_file.h"
#include "formats/file/standard_streams.h"
#include "formats/vtk/vtu_writer.h"
#include "precompute/checkpoint/checkpoint.h"
#include "precompute/options/named_files.h"
#include "precompute/problem/model_geometry.h"
#include "precompute/problem/preview.h"
#include "precompute/provenance.h"
#include "precompute/ranks/rank_agreement.h"
#include "precompute/ranks/rank_table.h"
#include "precompute/ranks/row_gather.h"
#include "precompute/ranks/session.h"
#include "precompute/report.h"
#include "precompute/target_error.h"
#include "precompute/vega/import.h"

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

// --select: prints the selected vertices only.
void print_selection(const PrecomputeOptions& options) {
  const Problem problem = load_problem(options);
  for (const std::string& note : problem.notes)
    std::fprintf(stderr, "  %s\n", printable(note).c_str());
  const std::vector<VertexId> ids = unwrap(resolve_selector(options.select, problem.mesh));
  std::vector<Eigen::Vector3d> positions;
  for (const VertexId id : ids) positions.push_back(problem.mesh.vertices[id]);
  write_preview(options, problem);
  std::cout << describe_vertices(ids, positions) << "\n";
  unwrap(flush_standard_output());
}

// --preview without an output: writes the coloured surface only.
void preview_alone(const PrecomputeOptions& options) {
  const Problem problem = load_problem(options);
  for (const std::string& note : problem.notes)
    std::fprintf(stderr, "  %s\n", printable(note).c_str());
  write_preview(options, problem);
  const std::size_t held =
      std::count_if(problem.fixed.begin(), problem.fixed.end(),
                    [&problem](VertexId v) { return edge_of_point(problem.mesh, v) == nullptr; });
  std::fprintf(stderr, "  %s: %zu vertices held, %zu loaded\n", options.preview.c_str(), held,
               problem.load.vertices.size());
}

// Returns the rows of U in the order of the mesh's vertices.
BasisRows rows_of_mesh(const BasisData& data) {
  BasisRows rows(3 * static_cast<Eigen::Index>(data.vertex_count), data.lambda.size());
  for (const VertexBlock* block : {&data.surface, &data.interior})
    for (std::size_t i = 0; i < block->vertex_ids.size(); ++i)
      rows.middleRows(3 * Eigen::Index{block->vertex_ids[i]}, 3) =
          block->rows.middleRows(3 * static_cast<Eigen::Index>(i), 3);
  return rows;
}

void write_vtu(const PrecomputeOptions& options, const TetMesh& mesh, const BasisData& data,
               StageLog& log) {
  if (options.modes_vtu.empty()) return;
  log.begin("vtu");
  const BasisRows rows = rows_of_mesh(data);
  if (mesh.edges.empty())
    unwrap(write_modes_vtu(options.modes_vtu, mesh.vertices,
                           std::span<const Tetrahedron>(mesh.tetrahedra), rows, data.lambda));
  else
    unwrap(write_modes_vtu(options.modes_vtu, mesh.vertices,
                           std::span<const QuadraticCell>(quadratic_cells(mesh)), rows,
                           data.lambda));
  log.end(options.modes_vtu);
}

// Checks that outputs can be written before the work starts.
void require_outputs(const PrecomputeOptions& options) {
  unwrap(AtomicFile::create(options.output_path));
  if (!options.modes_vtu.empty()) unwrap(AtomicFile::create(options.modes_vtu));
  if (!options.preview.empty()) unwrap(AtomicFile::create(options.preview));
}

// Writes the files on rank 0, while other ranks send their rows.
void write_result(const CommandLine& line, PrecomputeResult& result, bool rows_are_here,
                  StageLog& log) {
  const PrecomputeOptions& options = line.options;
  if (options.encoding == BasisEncoding::kCompact) find_encoding_error(result, log);
  const auto& render = result.data.render;
  const bool on_bones = render && render->surface.rig != nullptr;
  if (options.keep_elements || on_bones) add_elements(result.problem, result.data);
  result.data.provenance = provenance_json(options, result);
  log.begin("file");
  Status written = rows_are_here ? write_basis(options.output_path, result.data, options.encoding)
                                 : write_basis(options.output_path, result.data,
                                               gathered_rows(result.basis(), result.data));
  if (!written && options.checkpoint.keep)
    written.error().message += "; the stages are kept: --resume continues from them";
  unwrap(std::move(written));
  log.end(options.output_path);
  write_vtu(options, result.problem.mesh, result.data, log);
}

std::vector<NamedFile> inputs_of(const PrecomputeOptions& options) {
  std::vector<NamedFile> inputs = input_files(options, options.config_path);
  inputs.push_back({options.import_basis, "--import-basis"});
  inputs.push_back({options.import_cubic, "--import-cubic"});
  return inputs;
}

// Checks that no output overwrites an input or another output.
void require_apart(const PrecomputeOptions& options) {
  unwrap(keep_apart({options.output_path, options.modes_vtu, options.preview}, inputs_of(options)));
}

void require_known_flags(const PrecomputeOptions& options) {
  for (const auto& selectors : options.fix_axis)
    if (!selectors.empty())
      throw Failure({ErrorKind::kUsage,
                     "--fix-x, --fix-y and --fix-z are for `tremolo-precompute reference`: a basis "
                     "holds vertices with --fix only"});
}

// Runs `work` on rank 0 only; if it fails there, all ranks throw.
template <class Work>
void on_first_rank(const Work& work) {
  on_all_ranks([&work] {
    if (mpi_rank() == 0) work();
    return true;
  });
}

// Returns true if only a selection or a preview was requested, so that nothing is to be computed.
bool handled_without_computing(const PrecomputeOptions& options) {
  const bool first_rank = mpi_rank() == 0;
  if (!options.select.empty()) {
    if (first_rank && !options.output_path.empty())
      std::fprintf(stderr, "  --select computes nothing: %s is not written\n",
                   options.output_path.c_str());
    if (first_rank) print_selection(options);
    return true;
  }
  if (!options.output_path.empty()) return false;
  if (first_rank) preview_alone(options);
  return true;
}

void run_import(const CommandLine& line, StageLog& log) {
  const PrecomputeOptions& options = line.options;
  const ImportRequest request{options, options.import_basis, options.import_cubic,
                              options.mass_given};
  ImportResult result = import_reduced(request, log);
  if (options.encoding == BasisEncoding::kCompact)
    result.findings.encoding_error = unwrap(compact_error(result.data));
  result.data.provenance = import_provenance(request, options.command_line, result);
  log.begin("file");
  unwrap(write_basis(options.output_path, result.data, options.encoding));
  log.end(options.output_path);
  write_vtu(options, result.problem.mesh, result.data, log);
  print_spectrum(result.data);
  if (line.json) std::cout << import_report(result);
  unwrap(flush_standard_output());
}

// Rejects --error-budget where it cannot be measured.
void require_measurable(const PrecomputeOptions& options) {
  if (!options.error_budget) return;
  if (mpi_ranks() > 1)
    throw Failure(
        {ErrorKind::kUsage, "--error-budget works in one process: start it without mpiexec"});
  if (options.load_at.empty() || options.load_force.isZero(0.0))
    throw Failure(content_error(
        "--error-budget is measured under the default load: give --load-at and --load-force"));
}

void measure_budget(const PrecomputeOptions& options, PrecomputeResult& result, StageLog& log) {
  if (!options.error_budget) return;
  log.begin("budget");
  result.findings.budget =
      measure_budget(BudgetSubject{result.problem, options.mass, result.data, result.rows,
                                   options.output_path, options.threads, options.memory});
  for (const std::string& reason : result.findings.budget->reasons)
    log.note("not measured, " + reason);
  log.end(describe(*result.findings.budget));
}

// Sends the rows of a rank other than 0, unless all rows have been collected.
void serve_first_rank(const PrecomputeResult& result, bool rows_are_here, StageLog& log) {
  log.begin("file");
  if (!rows_are_here) serve_rows(result.basis(), result.data);
  log.end("");
  gather_stages(log);
}

// Gathers the response at the places on rank 0. Collective.
void collect_response(PrecomputeResult& result) {
  if (result.response_places.empty()) return;
  GatheredRows rows = gather_rows(result.spread_response(), result.data);
  LocalResponse& response = result.data.response;
  for (const ResponsePlace& place : result.response_places) response.at.push_back(place.at);
  response.surface = std::move(rows.surface);
  response.render = std::move(rows.render);
  response.interior = std::move(rows.interior);
}

void compute(const CommandLine& line, StageLog& log) {
  const PrecomputeOptions& options = line.options;
  PrecomputeResult result =
      options.target_error ? precompute_to_target(options, log) : run_precompute(options, log);
  // These need all rows at once.
  const bool collect = options.encoding == BasisEncoding::kCompact || !options.modes_vtu.empty();
  if (collect) collect_rows(result.basis(), result.data);
  collect_response(result);
  if (mpi_rank() != 0) return serve_first_rank(result, collect, log);
  try {
    write_result(line, result, collect, log);
    measure_budget(options, result, log);
  } catch (...) {
    if (mpi_ranks() > 1) stop_all_ranks(current_error());
    throw;
  }
  remove_checkpoint(options.checkpoint, log);
  const RankTable ranks = gather_stages(log);
  print_total(log, ranks);
  print_spectrum(result.data);
  // Stages read from a checkpoint have not read their solver's options.
  if (!result.findings.resumed) warn_of_unused_options();
  if (line.json) print_result(result, log, ranks);
  unwrap(flush_standard_output());
}

}  // namespace

void run_command(const CommandLine& line) {
  const PrecomputeOptions& options = line.options;
  if (mpi_ranks() > 1)
    require_agreement(
        on_all_ranks([&line] { return facts_of_start(line.settings, line.petsc_options); }));
  require_known_flags(options);
  require_measurable(options);
  on_first_rank([&options] { require_apart(options); });
  const GuardedInputs guard(inputs_of(options));
  if (handled_without_computing(options)) return;
  StageLog log(mpi_rank() != 0);
  on_first_rank([&options] { require_outputs(options); });
  if (options.import_basis.empty()) return compute(line, log);
  if (mpi_rank() == 0) run_import(line, log);
}

}  // namespace tremolo
