// tremolo-precompute: mesh in, basis file out.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <new>
#include <numbers>

#include <nlohmann/json.hpp>

#include "formats/atomic_file.h"
#include "formats/basis_writer.h"
#include "formats/selector_reader.h"
#include "formats/vtu_writer.h"
#include "precompute/failure.h"
#include "precompute/import.h"
#include "precompute/options.h"
#include "precompute/petsc.h"
#include "precompute/pipeline.h"
#include "precompute/term_signal.h"

namespace tremolo {
namespace {

void print_json(const PrecomputeResult& result, const StageLog& log) {
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
  Json frequencies = Json::array();
  for (double value : data.lambda)
    frequencies.push_back(std::sqrt(value) / (2.0 * std::numbers::pi));
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
      {"encoding", provenance.value("encoding", Json{{"name", "full"}})},
      {"notes", result.problem.notes},
      {"stages", stages}};
  std::cout << json.dump(2, ' ', false, Json::error_handler_t::replace) << "\n";
}

// The user sees at once what came out.
void print_spectrum(const BasisData& data) {
  std::fprintf(stderr, "  frequencies ");
  for (double value : data.lambda)
    std::fprintf(stderr, " %.4g", std::sqrt(value) / (2.0 * std::numbers::pi));
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
  std::cout << describe_vertices(ids, places) << "\n";
  if (!std::cout.flush()) throw Failure(system_error("standard output cannot be written"));
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

// Outputs that cannot be written, or would take the place of an input or of each other, are told
// before the work, not after it.
void require_outputs(const PrecomputeOptions& options) {
  unwrap(AtomicFile::create(options.output_path));
  if (!options.modes_vtu.empty()) unwrap(AtomicFile::create(options.modes_vtu));
  const auto same = [](const std::string& a, const std::string& b) {
    std::error_code ignored;
    return !a.empty() && !b.empty() &&
           (std::filesystem::path(a).lexically_normal() ==
                std::filesystem::path(b).lexically_normal() ||
            std::filesystem::equivalent(a, b, ignored));
  };
  for (const std::string& output : {options.output_path, options.modes_vtu})
    for (const std::string& input : {options.mesh_path, options.import_basis, options.import_cubic})
      if (same(output, input))
        throw Failure({ErrorKind::kUsage, output + ": the output would overwrite an input"});
  if (same(options.output_path, options.modes_vtu))
    throw Failure({ErrorKind::kUsage, options.modes_vtu + ": two outputs of this name"});
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
  if (!std::cout.flush()) throw Failure(system_error("standard output cannot be written"));
}

void run(const CommandLine& line) {
  const bool speak = mpi_rank() == 0;
  if (!line.options.select.empty()) {
    if (speak) print_selection(line.options);
    return;
  }
  StageLog log(!speak);
  if (speak) require_outputs(line.options);
  if (!line.options.import_basis.empty()) {
    if (speak) run_import(line, log);
    return;
  }
  PrecomputeResult result = run_precompute(line.options, log);
  if (!speak) return;
  if (line.options.encoding == BasisEncoding::kCompact) find_encoding_error(result, log);
  result.data.provenance = provenance_json(line.options, result);
  log.begin("file");
  unwrap(write_basis(line.options.output_path, result.data, line.options.encoding));
  log.end(line.options.output_path);
  write_vtu(line.options, result.problem.mesh, result.data, log);
  print_total(log);
  print_spectrum(result.data);
  for (const std::string& option : unused_petsc_options())
    log.note("warning: no solver asked for the PETSc option " + option + " (a typo?)");
  if (line.json) print_json(result, log);
  if (!std::cout.flush()) throw Failure(system_error("standard output cannot be written"));
}

int report(const Error& error) {
  std::fprintf(stderr, "tremolo-precompute: %s\n", error.message.c_str());
  return exit_code(error);
}

// What `run` threw, as an error.
Error caught() {
  try {
    throw;
  } catch (const Failure& failure) {
    return failure.error();
  } catch (const std::bad_alloc&) {
    return system_error("out of memory");
  } catch (const std::exception& exception) {
    return system_error(exception.what());
  }
}

int run_program(int count, char** words) {
  const auto parsed = parse_command_line(count, words);
  if (const int* code = std::get_if<int>(&parsed)) return *code;
  const auto& line = std::get<CommandLine>(parsed);
  try {
    const PetscSession session(words[0], line.petsc_options);
    take_term_signal();
    try {
      run(line);
      return 0;
    } catch (...) {
      const Error error = caught();
      // Errors of the input are the same on all ranks: one speaks. Others may be one rank's own,
      // and the rest would wait for it for ever.
      const bool common = error.kind == ErrorKind::kContent || error.kind == ErrorKind::kUsage;
      if (!common || mpi_rank() == 0) report(error);
      if (!common && mpi_ranks() > 1) MPI_Abort(PETSC_COMM_WORLD, exit_code(error));
      return exit_code(error);
    }
  } catch (...) {
    return report(caught());
  }
}

void hold_term_at_start(int, char**, char**) {
  block_term_signal();
}

// The threads of OpenBLAS are made while it is loaded: only .preinit_array comes before that.
[[gnu::section(".preinit_array"),
  gnu::used]] void (*const hold_before_libraries)(int, char**, char**) = hold_term_at_start;

}  // namespace
}  // namespace tremolo

int main(int count, char** words) {
  tremolo::remove_partial_files_on_signals();
  return tremolo::run_program(count, words);
}
