#include "precompute/command.h"

#include <algorithm>
#include <cstdio>
#include <iostream>

#include "common/text.h"
#include "formats/basis/selector_reader.h"
#include "formats/file/output_guard.h"
#include "formats/file/standard_streams.h"
#include "precompute/options/named_files.h"
#include "precompute/problem/preview.h"
#include "precompute/ranks/rank_agreement.h"
#include "precompute/report.h"
#include "precompute/vega/import.h"

namespace tremolo {
namespace {

// Runs `work` on rank 0 only; if it fails there, all ranks throw.
template <class Work>
void on_first_rank(const Work& work) {
  on_all_ranks([&work] {
    if (mpi_rank() == 0) work();
    return true;
  });
}

void print_notes(const Problem& problem) {
  for (const std::string& note : problem.notes)
    std::fprintf(stderr, "  %s\n", printable(note).c_str());
}

// --select: prints the selected vertices only.
void run(const SelectRequest& request) {
  if (mpi_rank() != 0) return;
  if (!request.unwritten.empty())
    std::fprintf(stderr, "  --select computes nothing: %s is not written\n",
                 request.unwritten.c_str());
  Problem problem = load_solid(request.solid);
  std::vector<Selector> selectors = request.solid.support.fixed;
  selectors.push_back(request.selector);
  if (std::string hint = up_axis_hint(request.solid.files, selectors, problem.mesh); !hint.empty())
    problem.notes.push_back(std::move(hint));
  for (std::string& note : near_notes(request.selector, problem.mesh))
    problem.notes.push_back(std::move(note));
  print_notes(problem);
  const std::vector<VertexId> ids = unwrap(resolve_selector(request.selector, problem.mesh));
  std::vector<Eigen::Vector3d> positions;
  for (const VertexId id : ids) positions.push_back(problem.mesh.vertices[id]);
  write_preview(request.preview, problem, ids);
  std::cout << describe_vertices(ids, positions) << "\n";
  unwrap(flush_standard_output());
}

// --preview without an output: writes the coloured surface only.
void run(const PreviewRequest& request) {
  if (mpi_rank() != 0) return;
  const Problem problem = load_problem(request.solid);
  print_notes(problem);
  write_preview(request.preview, problem);
  const std::size_t held =
      std::count_if(problem.fixed.begin(), problem.fixed.end(),
                    [&problem](VertexId v) { return edge_of_point(problem.mesh, v) == nullptr; });
  std::fprintf(stderr, "  %s: %zu vertices held, %zu loaded\n", request.preview.c_str(), held,
               problem.load.vertices.size());
}

// Checks that outputs can be written before the work starts.
void require_writable(const OutputRequest& output) {
  on_first_rank([&output] {
    unwrap(check_writable({output.basis, output.modes_vtu, output.preview}));
  });
}

void run(const ImportRequest& request) {
  require_writable(request.output);
  if (mpi_rank() != 0) return;
  StageLog log(false);
  ImportResult result = import_reduced(request, log);
  if (request.output.encoding == BasisEncoding::kCompact)
    result.findings.encoding_error = unwrap(compact_error(result.data));
  result.data.provenance = import_provenance(request, result);
  log.begin("file");
  unwrap(write_basis(request.output.basis, result.data, request.output.encoding));
  log.end(request.output.basis);
  write_vtu(request.output.modes_vtu, result.problem.mesh, result.data, log);
  print_spectrum(result.data);
  if (request.output.json) std::cout << import_report(result);
  unwrap(flush_standard_output());
}

void run(const PrecomputeRequest& request) {
  require_writable(request.output);
  compute(request);
}

std::vector<NamedFile> inputs_of(const CommandLine& line, const ProblemRequest& solid) {
  std::vector<NamedFile> inputs = input_files(solid, line.config_path);
  add_files_of_selector(line.select, "--select", inputs);
  inputs.push_back({line.import_basis, "--import-basis"});
  inputs.push_back({line.import_cubic, "--import-cubic"});
  inputs.push_back({line.fit.measured, "--fit"});
  return inputs;
}

}  // namespace

void run_command(const CommandLine& line) {
  if (mpi_ranks() > 1)
    require_agreement(
        on_all_ranks([&line] { return facts_of_start(line.settings, line.petsc_options); }));
  const Command command = read_command(line);
  const std::vector<NamedFile> inputs =
      std::visit([&line](const auto& request) { return inputs_of(line, request.solid); }, command);
  const OutputRequest& output = line.output;
  on_first_rank([&] {
    unwrap(keep_apart({output.basis, output.modes_vtu, output.preview}, inputs));
  });
  const GuardedInputs guard(inputs);
  std::visit([](const auto& request) { run(request); }, command);
}

}  // namespace tremolo
