// tremolo-mesh: surface or recipe in, tetrahedral mesh out.
#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <sys/prctl.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "assets/recipes/recipe.h"
#include "common/mesh/mesh_quality.h"
#include "common/mesh/surface_mesh.h"
#include "common/result.h"
#include "common/text.h"
#include "formats/file/atomic_file.h"
#include "formats/file/command_words.h"
#include "formats/file/output_guard.h"
#include "formats/file/standard_streams.h"
#include "formats/mesh/mesh_reader.h"
#include "formats/surface/surface_reader.h"
#include "formats/surface/surface_writer.h"
#include "precompute/mesher/cgal/cgal_mesher.h"
#include "precompute/mesher/mesher_answer.h"
#include "precompute/mesher/surface_mesher.h"
#include "precompute/mesher/surface_options.h"

namespace tremolo {
namespace {

struct Options {
  std::string input;  // a recipe's name or a surface file
  std::string output;
  std::string surface;
  std::string unit;
  SurfaceMeshOptions mesh;  // size and tets hold for recipes too
  int answer = -1;          // descriptor that tremolo-precompute reads from (mesher_answer.h)
};

// --tets is met to this fraction, in at most so many tries.
constexpr double kCountTolerance = 0.1;
constexpr int kTries = 6;

Recipe scaled(const Recipe& recipe, double factor) {
  Recipe copy = recipe;
  copy.size = [size = recipe.size, factor](const Eigen::Vector3d& x) { return factor * size(x); };
  copy.surface_error = factor * recipe.surface_error;
  return copy;
}

Result<TetMesh> mesh_to_count(const Recipe& recipe, int wanted) {
  double factor = 1.0;
  for (int attempt = 0; attempt < kTries; ++attempt) {
    Result<TetMesh> mesh = mesh_recipe(scaled(recipe, factor));
    if (!mesh) return mesh;
    const double share = static_cast<double>(mesh->tetrahedra.size()) / wanted;
    if (std::abs(share - 1.0) <= kCountTolerance) return mesh;
    factor *= std::cbrt(share);
  }
  return content_error(std::string(recipe.name) + ": no mesh of " + std::to_string(wanted) +
                       " tetrahedra within 10 % came out in " + std::to_string(kTries) + " tries");
}

Result<TetMesh> mesh_sample(Recipe recipe, const SurfaceMeshOptions& options) {
  if (options.size > 0.0)
    recipe.size = [size = options.size](const Eigen::Vector3d&) { return size; };
  return options.tets > 0 ? mesh_to_count(recipe, options.tets) : mesh_recipe(recipe);
}

Result<TetMesh> mesh_file(const Options& options) {
  Result<MesherAnswer> made = load_surface(options.input, options.unit, options.mesh);
  if (!made) return made.error();
  for (const std::string& note : made->notes)
    std::fprintf(stderr, "  %s\n", printable(note).c_str());
  return std::move(made->mesh);
}

Result<TetMesh> make_mesh(const Options& options) {
  Result<Recipe> recipe = find_recipe(options.input);
  if (recipe) return mesh_sample(std::move(*recipe), options.mesh);
  if (is_surface_file(options.input) || std::filesystem::exists(options.input))
    return mesh_file(options);
  return recipe.error();
}

void print_quality(const TetMesh& mesh) {
  const MeshQuality quality = mesh_quality(mesh);
  const BoundingBox box = bounding_box(mesh.vertices);
  std::printf("vertices          %zu\n", mesh.vertices.size());
  std::printf("tetrahedra        %zu\n", mesh.tetrahedra.size());
  std::printf("dihedral angles   %.2f to %.2f degrees\n", quality.min_dihedral_deg,
              quality.max_dihedral_deg);
  std::printf("radius ratio      %.4f at least, %.4f on average\n", quality.min_radius_ratio,
              quality.mean_radius_ratio);
  std::printf("volume            %.6g m^3\n", quality.volume);
  std::printf("bounding box      %.5g %.5g %.5g to %.5g %.5g %.5g m\n", box.low[0], box.low[1],
              box.low[2], box.high[0], box.high[1], box.high[2]);
}

Status write_all(int descriptor, const std::vector<std::byte>& bytes) {
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t count = ::write(descriptor, bytes.data() + at, bytes.size() - at);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return os_error("the mesh cannot be handed over in memory");
    at += count;
  }
  return Success{};
}

// Writes the answer to the program that started this one; this one ends when that one does.
Status answer(const Options& options) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::signal(SIGXFSZ, SIG_IGN);  // a limit on the size of files is an error of write() then
  Result<MesherAnswer> made = system_error("out of memory");
  try {
    made = load_surface(options.input, options.unit, options.mesh);
  } catch (const std::bad_alloc&) {
  }
  const Status written = write_all(options.answer, encode_answer(made));
  if (written) return Success{};
  // The reason in place of the mesh; it is short.
  const Error reason{written.error().kind, options.input + ": " + written.error().message};
  if (::ftruncate(options.answer, 0) != 0 || ::lseek(options.answer, 0, SEEK_SET) != 0)
    return reason;
  return write_all(options.answer, encode_answer(reason));
}

// The mesh is written as MSH, which a name of another format would hide.
Status check_extension(const std::string& path) {
  const std::string extension = lower_case(std::filesystem::path(path).extension().string());
  constexpr std::array<std::string_view, 12> kOther = {".vtk",  ".vtu",  ".pvtu", ".inp",
                                                       ".bdf",  ".nas",  ".fem",  ".veg",
                                                       ".vegb", ".node", ".ele",  ".tremolo"};
  const bool other =
      is_surface_file(path) || std::find(kOther.begin(), kOther.end(), extension) != kOther.end();
  if (!other) return Success{};
  return Error{ErrorKind::kUsage,
               "--output " + path +
                   ": tetrahedra are written as MSH 2.2, into a file named .msh; " +
                   "--surface writes the boundary as .obj, .ply or .inc"};
}

Status run(const Options& options) {
  if (options.answer >= 0) return answer(options);
  // A recipe's name has priority over a file of that name.
  const NamedFile input{find_recipe(options.input) ? "" : options.input, "the surface", true};
  if (Status status = keep_apart({options.output, options.surface}, {input}); !status)
    return status;
  if (Status status = check_extension(options.output); !status) return status;
  if (Status status = check_writable({options.output, options.surface}); !status) return status;
  const GuardedInputs guard({input});
  const Result<TetMesh> mesh = make_mesh(options);
  if (!mesh) return mesh.error();
  if (!options.surface.empty())
    if (Status status = write_surface(options.surface, boundary_mesh(*mesh)); !status)
      return status;
  if (Status status = write_msh(options.output, *mesh); !status) return status;
  print_quality(*mesh);
  return Success{};
}

// Returns the exit code if the program must end.
std::optional<int> parse(int count, char** words, Options& options) {
  CLI::App app{
      "Cuts a surface, or one of the sample solids, into tetrahedra. Holes, crossings, repeats "
      "and\n"
      "reversed triangles are repaired and reported. For a surface that cannot be meshed the "
      "message says what to do."};
  app.name("tremolo-mesh");
  app.failure_message(one_line_message);
  app.set_version_flag("--version", std::string("tremolo-mesh ") + TREMOLO_VERSION);
  app.add_option(
         "input", options.input,
         "a surface file (obj ply stl off gltf glb fbx dae 3ds ...), or one of: " + recipe_names())
      ->required();
  CLI::Option* output =
      app.add_option("-o,--output", options.output, "the mesh to write, MSH 2.2 binary (.msh)");
  add_surface_options(app, options.mesh, options.unit);
  app.add_option("--surface", options.surface,
                 "also write the boundary, as .obj, .ply or .inc (POV-Ray)");
  app.add_option("--answer", options.answer)->group("")->excludes(output);
  if (const std::optional<int> code = read_words(app, count, words)) return code;
  if (options.answer >= 0 || !options.output.empty()) return std::nullopt;
  std::fprintf(stderr, "tremolo-mesh: --output is required (--help lists the options)\n");
  return exit_code(ErrorKind::kUsage);
}

int run_program(int count, char** words) {
  Options options;
  if (const auto code = parse(count, words, options)) return *code;
  const Status status = run(options);
  if (status) return flush_standard_output() ? 0 : exit_code(ErrorKind::kSystem);
  std::fprintf(stderr, "tremolo-mesh: %s\n", printable(status.error().message).c_str());
  return exit_code(status.error());
}

}  // namespace
}  // namespace tremolo

int main(int count, char** words) {
  tremolo::hold_standard_streams();
  try {
    tremolo::remove_partial_files_on_signals();
    return tremolo::run_program(count, words);
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "tremolo-mesh: out of memory\n");
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "tremolo-mesh: %s\n", failure.what());
  }
  return static_cast<int>(tremolo::ErrorKind::kSystem);
}
