// tremolo-precompute: computes a basis file from a mesh.
#include <string_view>

#include "formats/file/atomic_file.h"
#include "formats/file/standard_streams.h"
#include "precompute/collider/make_collider.h"
#include "precompute/command.h"
#include "precompute/ranks/session.h"
#include "precompute/reference/reference_options.h"
#include "precompute/system/blas_room.h"
#include "precompute/system/blas_threads.h"
#include "precompute/system/petsc.h"
#include "precompute/system/term_signal.h"
#include "precompute/tets/make_tets.h"

namespace tremolo {
namespace {

int run_program(int count, char** words) {
  if (count > 1 && std::string_view(words[1]) == "reference") {
    const auto parsed = parse_reference_line(count - 1, words + 1);
    if (const int* code = std::get_if<int>(&parsed)) return *code;
    const auto& options = std::get<ReferenceOptions>(parsed);
    return run_session(words[0], options.petsc_options, options.solid.threads, [&] {
      moves_in_world(options) ? run_in_world(options) : run_reference(options);
    });
  }
  if (count > 1 && std::string_view(words[1]) == "collider") {
    const auto parsed = parse_collider_line(count - 1, words + 1);
    if (const int* code = std::get_if<int>(&parsed)) return *code;
    const auto& options = std::get<ColliderOptions>(parsed);
    return run_session(words[0], {}, options.threads, [&] {
      if (mpi_rank() == 0) make_collider(options);
    });
  }
  if (count > 1 && std::string_view(words[1]) == "tets") {
    const auto parsed = parse_tets_line(count - 1, words + 1);
    if (const int* code = std::get_if<int>(&parsed)) return *code;
    const auto& options = std::get<TetsOptions>(parsed);
    return run_session(words[0], {}, options.solid.threads, [&] {
      if (mpi_rank() == 0) make_tets(options);
    });
  }
  const auto parsed = parse_command_line(count, words);
  if (const int* code = std::get_if<int>(&parsed)) return *code;
  const auto& line = std::get<CommandLine>(parsed);
  return run_session(words[0], line.petsc_options, line.solid.threads, [&] { run_command(line); });
}

void prepare_for_libraries(int, char**, char** environment) {
  block_term_signal();
  require_room_for_blas(environment);
}

// OpenBLAS creates its threads and buffers when it is loaded; only .preinit_array runs before that.
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
