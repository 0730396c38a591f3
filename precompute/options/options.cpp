#include "precompute/options/options.h"

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <optional>

#include <CLI/CLI.hpp>

#include "formats/file/command_words.h"
#include "precompute/checkpoint/checkpoint.h"
#include "precompute/options/config_option.h"
#include "precompute/options/solid_options.h"
#include "precompute/system/failure.h"
#include "precompute/system/option_checks.h"

namespace tremolo {
namespace {

// Returns the words that affect the result. Output paths, threads and printing options are left
// out, so that the same model gives the same file.
std::string without_output_options(const std::vector<std::string>& words) {
  std::string line;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (word == "--json" || word == "--limits" || word == "--error-budget" ||
        word.starts_with("--checkpoint") || word.starts_with("--resume") ||
        word.starts_with("--output=") || word.starts_with("--modes-vtu=") ||
        word.starts_with("--preview=") || word.starts_with("--threads=") ||
        (word.starts_with("-o") && word.size() > 2))
      continue;
    if (word == "-o" || word == "--output" || word == "--threads" || word == "--modes-vtu" ||
        word == "--preview") {
      ++i;
      continue;
    }
    if (!line.empty()) line += ' ';
    line += word;
  }
  return line;
}

// Options that are parsed from text.
struct ModelTexts {
  std::string encoding = "full";
  std::string solver = "auto";
  std::uint64_t memory = 0;  // bytes
};

void add_outputs(CLI::App& app, PrecomputeOptions& options, ModelTexts& texts) {
  app.add_option("-o,--output", options.output_path, "the basis file to write");
  app.add_option(
      "--render", options.render_path,
      "surface that is drawn in place of the mesh's boundary and moves with it: .obj .ply "
      ".stl .gltf .glb .fbx ... (default: the surface that was meshed)");
  app.add_option("--select", options.select,
                 "print the vertices that a selector chooses, and compute nothing");
  app.add_option("--preview", options.preview,
                 "write the mesh's boundary, .ply, painted: blue what is held, red what is loaded, "
                 "with an arrow, green what --select finds; without --output nothing is computed");
  app.add_flag("--keep-elements", options.keep_elements,
               "keep the tetrahedra and their masses in the file: a body on several bones shares "
               "its mass among them");
  app.add_option(
      "--response-at", options.response_at,
      "keep the compliance of vertices that the basis does not represent, so that a force "
      "there makes a dent: a selector, or `load` for the default load; again for "
      "more");
  app.add_option("--modes-vtu", options.modes_vtu,
                 "also write the modes on the tetrahedra, .vtu, for ParaView and meshio");
  app.add_option(
         "--encoding", texts.encoding,
         "full (f64), or compact: coefficients f32, basis rows 16 bits; the error is printed")
      ->check(CLI::IsMember({"full", "compact"}))
      ->capture_default_str();
}

void add_model_options(CLI::App& app, PrecomputeOptions& options) {
  app.add_option("--linear-modes", options.linear_modes, "K, linear modes (default 20)");
  app.add_option("--modes", options.modes,
                 "R, coordinates to keep (default 30; with --linear all linear modes)");
  CLI::Option* target_error = app.add_option(
      "--target-error", options.target_error,
      "E, e.g. 0.02: as many coordinates as it takes for the static displacement under the\n"
      "default load to be off by E at most, measured against the whole mesh");
  app.add_flag("--error-budget", options.error_budget,
               "measure what the mesh (against one refined), the basis (against the mesh) and the "
               "step leave out under the default load, and tell which to spend on");
  app.add_flag("--certify,!--no-certify", options.certify,
               "count the modes by inertia as well: one more factorisation (default: yes)");
  CLI::Option* linear =
      app.add_flag("--linear", options.linear,
                   "the linear modes alone: no derivatives, no cubic and quartic terms");
  target_error->excludes(linear);
  app.add_option("--derivatives", options.derivatives,
                 "up to which order modes are derived: 2 (modal derivatives) or 3 (also those of\n"
                 "third order along the softest modes, for what bends by several thicknesses)")
      ->check(CLI::IsMember({2, 3}))
      ->capture_default_str();
}

void add_import(CLI::App& app, PrecomputeOptions& options) {
  CLI::Option* basis = app.add_option(
      "--import-basis", options.import_basis,
      "VegaFEM's basis, .U, over the vertices of this mesh: nothing is solved. It is "
      "orthonormal in the lumped mass, of which --density is part (--material file: the "
      "mesh file's own)");
  // --up: the rows of an imported basis refer to the axes of the mesh's file.
  for (const char* other :
       {"--linear-modes", "--modes", "--linear", "--target-error", "--error-budget", "--point-mass",
        "--up", "--refine", "--keep-elements", "--response-at"})
    basis->excludes(app.get_option(other));
  CLI::Option* cubic =
      app.add_option("--import-cubic", options.import_cubic,
                     "VegaFEM's polynomials of the reduced forces, .cub; the stiffness is theirs");
  cubic->needs(basis);
  basis->needs(cubic);
}

void add_solver_options(CLI::App& app, PrecomputeOptions& options, ModelTexts& texts) {
  app.add_option(
         "--solver", texts.solver,
         "cholmod (a factor in one process), mumps (spread over ranks), iterative (multigrid,\n"
         "no factor) or auto: a factor where memory allows")
      ->check(CLI::IsMember({"auto", "cholmod", "mumps", "iterative"}))
      ->capture_default_str();
  app.add_option("--memory", texts.memory, "bytes a rank may use, e.g. 4GB (default: what is free)")
      ->transform(byte_count());
  CLI::Option* checkpoint = app.add_flag(
      "--checkpoint", options.checkpoint.keep,
      "keep every finished stage in the folder OUTPUT.checkpoint until all is written");
  CLI::Option* resume =
      app.add_flag("--resume", options.checkpoint.resume,
                   "go on from the stages in OUTPUT.checkpoint, and keep the further ones there");
  for (CLI::Option* option : {checkpoint, resume})
    option->excludes(app.get_option("--import-basis"))->excludes(app.get_option("--target-error"));
  app.add_flag("--limits", options.limits,
               "measure this machine and print the shortest time each stage could take on it");
}

void finish_model_options(const ModelTexts& texts, PrecomputeOptions& options) {
  for (const LinearSolver each :
       {LinearSolver::kCholmod, LinearSolver::kMumps, LinearSolver::kIterative})
    if (texts.solver == name_of(each)) options.solver = each;
  if (texts.memory > 0) options.memory = static_cast<double>(texts.memory);
  options.encoding = texts.encoding == "compact" ? BasisEncoding::kCompact : BasisEncoding::kFull;
  options.checkpoint.keep = options.checkpoint.keep || options.checkpoint.resume;
  options.checkpoint.folder = checkpoint_folder(options.output_path);
  options.imported = !options.import_basis.empty();
}

// False when the options contradict each other (the text has been printed).
bool check_options(const CLI::App& app, const std::vector<std::string>& words,
                   PrecomputeOptions& options) {
  const auto given = [&words](const std::string& flag) {
    return std::any_of(words.begin(), words.end(), [&flag](const std::string& word) {
      return word == flag || word.starts_with(flag + "=");
    });
  };
  if (options.output_path.empty() && options.select.empty() && options.preview.empty()) {
    std::cerr << "tremolo-precompute: --output is required\n";
    return false;
  }
  // On the command line --linear overrules the derivatives of a config file.
  if (options.linear && app.get_option("--derivatives")->count() > 0 &&
      (!given("--linear") || given("--derivatives"))) {
    std::cerr << "tremolo-precompute: --linear excludes --derivatives\n";
    return false;
  }
  if (!options.target_error || !options.modes) return true;
  if (given("--modes")) {
    std::cerr << "tremolo-precompute: --target-error chooses the coordinates: leave --modes out\n";
    return false;
  }
  options.modes.reset();  // set in a config file
  return true;
}

// The exit code when the words are not a command line, or ask for help (the text has been printed).
std::optional<int> parse(CLI::App& app, const std::vector<std::string>& words) {
  try {
    return read_words(app, words);
  } catch (const Failure& failure) {
    std::cerr << "tremolo-precompute: " << failure.what() << "\n";
    return exit_code(failure.error());
  }
}

}  // namespace

std::variant<CommandLine, int> parse_command_line(int count, char** words) {
  CommandLine line;
  PrecomputeOptions& options = line.options;
  const int wrong = exit_code({ErrorKind::kUsage, ""});
  std::vector<std::string> own;
  int at = 1;
  for (; at < count && std::string(words[at]) != "--"; ++at) own.emplace_back(words[at]);
  options.command_line = without_output_options(own);
  for (++at; at < count; ++at) line.petsc_options.emplace_back(words[at]);

  CLI::App app{
      "Turns a tetrahedral mesh into a basis file for tremolo. Units are SI.\n"
      "`tremolo-precompute reference MESH ...` moves the whole mesh instead, to judge a basis by: "
      "see\n"
      "`tremolo-precompute reference --help`.\n"
      "`tremolo-precompute collider SURFACE -o OUT.collider` makes what bodies bump into.\n"
      "`tremolo-precompute tets MESH -o OUT.tets` writes the mesh for bodies of whole tetrahedra.\n"
      "What follows -- goes to PETSc and SLEPc (their inner solver has the prefix -st_)."};
  app.name("tremolo-precompute");
  app.failure_message(one_line_message);
  app.set_version_flag("--version", std::string("tremolo-precompute ") + TREMOLO_VERSION);
  app.allow_config_extras(CLI::config_extras_mode::error);
  add_config_option(app, "read options from a TOML file (keys are the long flag names)");
  SolidTexts solid_texts;
  ModelTexts model_texts;
  add_solid_options(app, options, solid_texts);
  // These are flags of `reference`; given here, they get an error that says so.
  for (const char* flag : {"--fix-x", "--fix-y", "--fix-z"}) app.get_option(flag)->group("");
  add_outputs(app, options, model_texts);
  add_model_options(app, options);
  add_import(app, options);
  add_solver_options(app, options, model_texts);
  app.add_flag("--json", line.json, "print one JSON object on stdout");

  if (!vectors_are_words(own, "--load-force")) return wrong;
  if (const std::optional<int> code = parse(app, own)) return *code;
  options.config_path = config_path(app);
  if (!check_options(app, own, options)) return wrong;
  line.settings = app.config_to_str(true);
  options.mass_given = app.get_option("--mass")->count() > 0;
  finish_model_options(model_texts, options);
  if (!finish_solid_options(solid_texts, options)) return wrong;
  return line;
}

}  // namespace tremolo
