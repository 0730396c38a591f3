// tremolo-precompute: mesh in, basis file out.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iostream>
#include <thread>

#include <nlohmann/json.hpp>

#include "common/hertz.h"
#include "formats/basis/basis_writer.h"
#include "formats/basis/selector_reader.h"
#include "formats/file/atomic_file.h"
#include "formats/file/standard_streams.h"
#include "formats/vtk/vtu_writer.h"
#include "precompute/checkpoint/checkpoint.h"
#include "precompute/options/named_files.h"
#include "precompute/options/options.h"
#include "precompute/pipeline.h"
#include "precompute/problem/preview.h"
#include "precompute/ranks/rank_agreement.h"
#include "precompute/ranks/rank_table.h"
#include "precompute/reference/reference_options.h"
#include "precompute/system/blas_room.h"
#include "precompute/system/blas_threads.h"
#include "precompute/system/failure.h"
#include "precompute/system/petsc.h"
#include "precompute/system/term_signal.h"
#include "precompute/target_error.h"
#include "precompute/vega/import.h"

namespace tremolo {
namespace {

void print_result(const PrecomputeResult& result, const StageLog& log, const RankTable& ranks) {
  using Json = nlohmann::ordered_json;
  const BasisData& data = result.data;
  const auto r = static_cast<std::size_t>(data.lambda.size());
  Json stages = Json::array();
  for (const StageRecord& stage : log.records())
    stages.push_back({{"name", stage.name},
                      {"seconds", stage.seconds},
                      {"cpu_seconds", stage.cpu_seconds},
                      {"limit_seconds", stage.limit_seconds},
                      {"limit_reason", stage.limit_reason},
                      {"peak_bytes", stage.peak_bytes},
                      {"detail", stage.detail}});
  Json of_ranks = Json::array();
  for (const RankTable::Row& row : ranks.rows)
    of_ranks.push_back({{"stage", row.stage},
                        {"seconds", row.seconds},
                        {"cpu_seconds", row.cpu_seconds},
                        {"peak_bytes", row.peak_bytes}});
  Json frequencies = Json::array();
  for (double value : data.lambda) frequencies.push_back(hertz(value));
  std::vector<double> cut(data.singular_values.begin() +
                              static_cast<std::ptrdiff_t>(std::min(r, data.singular_values.size())),
                          data.singular_values.end());
  const Json provenance = Json::parse(data.provenance);
  Json materials = Json::array();
  if (provenance.contains("materials")) materials = provenance["materials"];
  if (provenance.contains("material")) materials.push_back(provenance["material"]);
  const Json json = {
      {"n", data.vertex_count},
      {"m", data.tetrahedron_count},
      {"r", r},
      {"linear_modes", data.linear_mode_count},
      {"rigid_modes", data.rigid_mode_count},
      {"frequencies_hz", frequencies},
      {"explicit_step_limit_s", 2.0 / std::sqrt(data.lambda[data.lambda.size() - 1])},
      {"total_mass_kg", data.total_mass},
      {"materials", materials},
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
      {"encoding", provenance.value("encoding", Json{{"name", "full"}})},
      {"notes", result.problem.notes},
      {"ranks", mpi_ranks()},
      {"stages", stages},
      {"stages_of_ranks", of_ranks}};
  print_json(json);
}

// The user sees at once what came out.
void print_spectrum(const BasisData& data) {
  std::fprintf(stderr, "  frequencies ");
  for (double value : data.lambda) std::fprintf(stderr, " %.4g", hertz(value));
  std::fprintf(stderr, " Hz\n  explicit methods are stable below a step of %.4g s\n",
               2.0 / std::sqrt(data.lambda[data.lambda.size() - 1]));
}

void print_total(const StageLog& log) {
  double seconds = 0, cpu_seconds = 0;
  std::uint64_t peak = 0;
  for (const StageRecord& stage : log.records()) {
    seconds += stage.seconds;
    cpu_seconds += stage.cpu_seconds;
    peak = std::max(peak, stage.peak_bytes);
  }
  std::fprintf(stderr, "  %-12s %7.2f s %7.2f s cpu %6.0f MB\n", "total", seconds, cpu_seconds,
               static_cast<double>(peak) / 1e6);
}

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

// --select: what it chooses, and nothing else.
void print_selection(const PrecomputeOptions& options) {
  const Problem problem = load_problem(options);
  for (const std::string& note : problem.notes) std::fprintf(stderr, "  %s\n", note.c_str());
  const std::vector<VertexId> ids = unwrap(resolve_selector(options.select, problem.mesh));
  std::vector<Eigen::Vector3d> places;
  for (const VertexId id : ids) places.push_back(problem.mesh.vertices[id]);
  write_preview(options, problem);
  std::cout << describe_vertices(ids, places) << "\n";
  unwrap(flush_standard_output());
}

// --preview without an output: the painted surface, and nothing else.
void preview_alone(const PrecomputeOptions& options) {
  const Problem problem = load_problem(options);
  for (const std::string& note : problem.notes) std::fprintf(stderr, "  %s\n", note.c_str());
  write_preview(options, problem);
  std::fprintf(stderr, "  %s: %zu vertices held, %zu loaded\n", options.preview.c_str(),
               problem.fixed.size(), problem.load.vertices.size());
}

// Where each vertex of the mesh has its rows, all together again.
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
  unwrap(write_modes_vtu(options.modes_vtu, mesh.vertices,
                         std::span<const Tetrahedron>(mesh.tetrahedra), rows_of_mesh(data),
                         data.lambda));
  log.end(options.modes_vtu);
}

// Outputs that cannot be written are told before the work, not after it.
void require_outputs(const PrecomputeOptions& options) {
  unwrap(AtomicFile::create(options.output_path));
  if (!options.modes_vtu.empty()) unwrap(AtomicFile::create(options.modes_vtu));
  if (!options.preview.empty()) unwrap(AtomicFile::create(options.preview));
}

void run_import(const CommandLine& line, StageLog& log) {
  const PrecomputeOptions& options = line.options;
  ImportResult result = import_reduced(options, log);
  if (options.encoding == BasisEncoding::kCompact)
    result.findings.encoding_error = unwrap(compact_error(result.data));
  result.data.provenance = import_provenance(options, result);
  log.begin("file");
  unwrap(write_basis(options.output_path, result.data, options.encoding));
  log.end(options.output_path);
  write_vtu(options, result.problem.mesh, result.data, log);
  print_spectrum(result.data);
  if (line.json) std::cout << import_report(result);
  unwrap(flush_standard_output());
}

int report(const Error& error) {
  std::fprintf(stderr, "tremolo-precompute: %s\n", error.message.c_str());
  return exit_code(error);
}

// The end of a run on rank 0, the others handing it their rows meanwhile.
void write_result(const CommandLine& line, PrecomputeResult& result, bool rows_are_here,
                  StageLog& log) {
  const PrecomputeOptions& options = line.options;
  if (options.encoding == BasisEncoding::kCompact) find_encoding_error(result, log);
  result.data.provenance = provenance_json(options, result);
  log.begin("file");
  Status written = rows_are_here ? write_basis(options.output_path, result.data, options.encoding)
                                 : write_basis(options.output_path, result.data,
                                               gathered_rows(result.basis(), result.data));
  if (!written && options.checkpoint)
    written.error().message += "; the stages are kept: --resume goes on from there";
  unwrap(std::move(written));
  log.end(options.output_path);
  write_vtu(options, result.problem.mesh, result.data, log);
}

// A failure of one rank alone would leave the others waiting for ever.
[[noreturn]] void stop_all_ranks(const Error& error) {
  report(error);
  MPI_Abort(PETSC_COMM_WORLD, exit_code(error));
  std::abort();
}

// A typo in an option is a likely cause when a solver gives up.
void warn_of_unused_options() {
  for (const std::string& option : unused_petsc_options())
    std::fprintf(stderr, "  warning: no solver asked for the PETSc option %s (a typo?)\n",
                 option.c_str());
}

void run(const CommandLine& line) {
  if (mpi_ranks() > 1)
    require_agreement(
        on_all_ranks([&line] { return facts_of_start(line.settings, line.petsc_options); }));
  const bool speak = mpi_rank() == 0;
  for (const auto& selectors : line.options.fix_axis)
    if (!selectors.empty())
      throw Failure({ErrorKind::kUsage,
                     "--fix-x, --fix-y and --fix-z are for `tremolo-precompute reference`: a basis "
                     "holds vertices with --fix only"});
  // No output takes the place of an input or of another one.
  on_all_ranks([&] {
    const PrecomputeOptions& options = line.options;
    if (speak)
      unwrap(keep_apart({options.output_path, options.modes_vtu, options.preview},
                        input_files(options)));
    return true;
  });
  if (!line.options.select.empty()) {
    if (speak && !line.options.output_path.empty())
      std::fprintf(stderr, "  --select computes nothing: %s is not written\n",
                   line.options.output_path.c_str());
    if (speak) print_selection(line.options);
    return;
  }
  if (line.options.output_path.empty()) {
    if (speak) preview_alone(line.options);
    return;
  }
  StageLog log(!speak);
  on_all_ranks([&] {
    if (speak) require_outputs(line.options);
    return true;
  });
  if (!line.options.import_basis.empty()) {
    if (speak) run_import(line, log);
    return;
  }
  PrecomputeResult result = line.options.target_error ? precompute_to_target(line.options, log)
                                                      : run_precompute(line.options, log);
  // These look at all rows at once.
  const bool collect =
      line.options.encoding == BasisEncoding::kCompact || !line.options.modes_vtu.empty();
  if (collect) collect_rows(result.basis(), result.data);
  if (!speak) {
    log.begin("file");
    if (!collect) serve_rows(result.basis(), result.data);
    log.end("");
    gather_stages(log);
    return;
  }
  try {
    write_result(line, result, collect, log);
  } catch (...) {
    if (mpi_ranks() > 1) stop_all_ranks(current_error());
    throw;
  }
  remove_checkpoint(line.options, log);
  print_total(log);
  const RankTable ranks = gather_stages(log);
  if (mpi_ranks() > 1)
    std::fprintf(stderr, "  processor time and peak memory of each rank\n%s\n",
                 table_text(ranks).c_str());
  print_spectrum(result.data);
  // Stages that were there have asked for none.
  if (!result.findings.resumed) warn_of_unused_options();
  if (line.json) print_result(result, log, ranks);
  unwrap(flush_standard_output());
}

// `work`, whose BLAS is called by so many threads at once, with PETSc running.
int run_session(const char* program, const std::vector<std::string>& petsc_options,
                unsigned threads, const std::function<void()>& work) {
  try {
    take_room_for_blas(threads);
    const PetscSession session(program, petsc_options);
    take_term_signal();
    try {
      work();
      return 0;
    } catch (const SharedFailure& failure) {
      return mpi_rank() == 0 ? report(failure.error()) : exit_code(failure.error());
    } catch (...) {
      const Error error = current_error();
      // Errors of the input are the same on all ranks: one speaks. Others may be one rank's own,
      // and the rest would wait for it for ever.
      const bool common = error.kind == ErrorKind::kContent || error.kind == ErrorKind::kUsage;
      const bool alone = mpi_ranks() == 1 || (!common && !all_ranks_failed());
      if (alone || mpi_rank() == 0) {
        report(error);
        if (error.kind == ErrorKind::kSolver) warn_of_unused_options();
      } else if (!common) {
        std::this_thread::sleep_for(std::chrono::seconds(5));  // rank 0 speaks and ends all
      }
      if (!common && mpi_ranks() > 1) MPI_Abort(PETSC_COMM_WORLD, exit_code(error));
      return exit_code(error);
    }
  } catch (...) {
    return report(current_error());
  }
}

int run_program(int count, char** words) {
  if (count > 1 && std::string_view(words[1]) == "reference") {
    const auto parsed = parse_reference_line(count - 1, words + 1);
    if (const int* code = std::get_if<int>(&parsed)) return *code;
    const auto& options = std::get<ReferenceOptions>(parsed);
    return run_session(words[0], options.petsc_options, options.solid.threads,
                       [&] { run_reference(options); });
  }
  const auto parsed = parse_command_line(count, words);
  if (const int* code = std::get_if<int>(&parsed)) return *code;
  const auto& line = std::get<CommandLine>(parsed);
  return run_session(words[0], line.petsc_options, line.options.threads, [&] { run(line); });
}

void prepare_for_libraries(int, char**, char** environment) {
  block_term_signal();
  require_room_for_blas(environment);
}

// The threads of OpenBLAS and their buffers are made while it is loaded: only .preinit_array comes
// before that.
[[gnu::section(".preinit_array"),
  gnu::used]] void (*const before_libraries)(int, char**, char**) = prepare_for_libraries;

}  // namespace
}  // namespace tremolo

int main(int count, char** words) {
  tremolo::hold_standard_streams();
  tremolo::use_fast_blas_kernels(words);
  tremolo::remove_partial_files_on_signals();
  return tremolo::run_program(count, words);
}
