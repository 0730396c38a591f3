#include "precompute/options/options.h"

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <optional>

#include <CLI/CLI.hpp>

#include "formats/file/command_words.h"
#include "precompute/checkpoint/checkpoint.h"
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
    if (word == "--json" || word == "--sensitivities" || word == "--limits" ||
        word == "--error-budget" || word.starts_with("--checkpoint") ||
        word.starts_with("--resume") || word.starts_with("--output=") ||
        word.starts_with("--modes-vtu=") || word.starts_with("--preview=") ||
        word.starts_with("--threads=") || (word.starts_with("-o") && word.size() > 2))
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

void add_outputs(CLI::App& app, CommandLine& line) {
  app.add_option("-o,--output", line.output.basis, "the basis file to write");
  app.add_option(
      "--render", line.solid.render,
      "surface that is drawn in place of the mesh's boundary and moves with it: .obj .ply "
      ".stl .gltf .glb .fbx ... (default: the surface that was meshed)");
  app.add_option("--select", line.select,
                 "print the vertices that a selector chooses, and compute nothing");
  app.add_option("--preview", line.output.preview,
                 "write the mesh's boundary, .ply, painted: blue what is held, red what is loaded, "
                 "with an arrow, green what --select finds; without --output nothing is computed");
  app.add_flag("--keep-elements", line.output.keep_elements,
               "keep the tetrahedra and their masses in the file: a body on several bones shares "
               "its mass among them");
  app.add_option(
      "--response-at", line.response_at,
      "keep the compliance of vertices that the basis does not represent, so that a force "
      "there makes a dent: a selector, or `load` for the default load; again for "
      "more");
  app.add_option("--modes-vtu", line.output.modes_vtu,
                 "also write the modes on the tetrahedra, .vtu, for ParaView and meshio");
  app.add_option(
         "--encoding", line.encoding,
         "full (f64), or compact: coefficients f32, basis rows 16 bits; the error is printed")
      ->check(CLI::IsMember({"full", "compact"}))
      ->capture_default_str();
}

void add_model_options(CLI::App& app, CommandLine& line) {
  app.add_option(
      "--linear-modes", line.basis.linear_modes,
      "K, linear modes (default: R/2, at most 20; 20 if R is below 30, with --linear and "
      "with --target-error)");
  app.add_option("--modes", line.basis.modes,
                 "R, coordinates to keep (default 30; with --linear all linear modes)");
  CLI::Option* target_error = app.add_option(
      "--target-error", line.basis.target_error,
      "E, e.g. 0.02: as many coordinates as it takes for the static displacement under the\n"
      "default load to be off by E at most, measured against the whole mesh");
  app.add_flag("--error-budget", line.output.error_budget,
               "measure what the mesh (against one refined), the basis (against the mesh) and the "
               "step leave out under the default load, and tell which to spend on");
  app.add_flag("--certify,!--no-certify", line.solve.certify,
               "count the modes by inertia as well: one more factorisation (default: yes)");
  CLI::Option* linear =
      app.add_flag("--linear", line.basis.linear,
                   "the linear modes alone: no derivatives, no cubic and quartic terms");
  target_error->excludes(linear);
  app.add_option(
      "--keep-modes", line.basis.keep_modes,
      "N, so many of the lowest linear modes are taken as they are, and derivatives "
      "fill the rest\n"
      "(default: R/2 of them if the selection by singular values would lose one; 0: that "
      "selection)");
  app.add_option("--derivatives", line.basis.derivatives,
                 "up to which order modes are derived: 2 (modal derivatives) or 3 (also those of\n"
                 "third order along the softest modes, for what bends by several thicknesses)")
      ->check(CLI::IsMember({2, 3}))
      ->capture_default_str();
}

void add_fit(CLI::App& app, CommandLine& line) {
  app.add_flag("--sensitivities", line.output.sensitivities,
               "tell how each frequency depends on each material's E, nu and density; without "
               "--output the modes alone are computed");
  CLI::Option* fit = app.add_option(
      "--fit", line.fit.measured,
      "CSV of measured frequencies and damping: the materials are fitted to it first, and told "
      "with their uncertainty; without --output nothing else is computed");
  app.add_option("--fit-for", line.fit.unknowns,
                 "what is fitted: young, poisson, density, or young:REGION, separated by commas")
      ->capture_default_str()
      ->needs(fit);
  app.add_option("--fit-mass", line.fit.mass,
                 "KG or KG:SD, the measured mass and its standard deviation; with it the density "
                 "can be fitted")
      ->needs(fit);
}

void add_import(CLI::App& app, CommandLine& line) {
  CLI::Option* basis = app.add_option(
      "--import-basis", line.import_basis,
      "VegaFEM's basis, .U, over the vertices of this mesh: nothing is solved. It is "
      "orthonormal in the lumped mass, of which --density is part (--material file: the "
      "mesh file's own)");
  // --up: the rows of an imported basis refer to the axes of the mesh's file.
  for (const char* other : {"--linear-modes", "--modes", "--keep-modes", "--linear",
                            "--target-error", "--error-budget", "--point-mass", "--up", "--refine",
                            "--keep-elements", "--response-at", "--fit", "--sensitivities"})
    basis->excludes(app.get_option(other));
  CLI::Option* cubic =
      app.add_option("--import-cubic", line.import_cubic,
                     "VegaFEM's polynomials of the reduced forces, .cub; the stiffness is theirs");
  cubic->needs(basis);
  basis->needs(cubic);
}

void add_solver_options(CLI::App& app, CommandLine& line) {
  app.add_option(
         "--solver", line.solver,
         "cholmod (a factor in one process), mumps (spread over ranks), iterative (multigrid,\n"
         "no factor) or auto: a factor where memory allows")
      ->check(CLI::IsMember({"auto", "cholmod", "mumps", "iterative"}))
      ->capture_default_str();
  app.add_option("--memory", line.memory, "bytes a rank may use, e.g. 4GB (default: what is free)")
      ->transform(byte_count());
  CLI::Option* checkpoint = app.add_flag(
      "--checkpoint", line.checkpoint.keep,
      "keep every finished stage in the folder OUTPUT.checkpoint until all is written");
  CLI::Option* resume =
      app.add_flag("--resume", line.checkpoint.resume,
                   "go on from the stages in OUTPUT.checkpoint, and keep the further ones there");
  for (CLI::Option* option : {checkpoint, resume})
    option->excludes(app.get_option("--import-basis"))->excludes(app.get_option("--target-error"));
  app.add_flag("--limits", line.solve.limits,
               "measure this machine and print the shortest time each stage could take on it");
}

// False when the options contradict each other (the text has been printed).
bool check_options(const CLI::App& app, const std::vector<std::string>& words, CommandLine& line) {
  const auto given = [&words](const std::string& flag) {
    return std::any_of(words.begin(), words.end(), [&flag](const std::string& word) {
      return word == flag || word.starts_with(flag + "=");
    });
  };
  const bool modes_only = !line.fit.measured.empty() || line.output.sensitivities;
  if (line.output.basis.empty() && line.select.empty() && line.output.preview.empty() &&
      !modes_only) {
    std::cerr << "tremolo-precompute: --output is required\n";
    return false;
  }
  if (line.output.basis.empty() && modes_only) {
    for (const char* flag : {"--checkpoint", "--resume", "--target-error", "--error-budget",
                             "--modes-vtu", "--response-at", "--keep-elements"})
      if (app.get_option(flag)->count() > 0) {
        std::cerr << "tremolo-precompute: " << flag << " needs --output\n";
        return false;
      }
  }
  // On the command line --linear and --target-error overrule the kept modes of a config file.
  for (const char* flag : {"--linear", "--target-error"})
    if (given("--keep-modes") && given(flag)) {
      std::cerr << "tremolo-precompute: " << flag << " excludes --keep-modes\n";
      return false;
    }
  if (line.basis.linear || line.basis.target_error) line.basis.keep_modes.reset();
  // On the command line --linear overrules the derivatives of a config file.
  if (line.basis.linear && app.get_option("--derivatives")->count() > 0 &&
      (!given("--linear") || given("--derivatives"))) {
    std::cerr << "tremolo-precompute: --linear excludes --derivatives\n";
    return false;
  }
  if (!line.basis.target_error || !line.basis.modes) return true;
  if (given("--modes")) {
    std::cerr << "tremolo-precompute: --target-error chooses the coordinates: leave --modes out\n";
    return false;
  }
  line.basis.modes.reset();  // set in a config file
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
  const int wrong = exit_code({ErrorKind::kUsage, ""});
  std::vector<std::string> own;
  int at = 1;
  for (; at < count && std::string(words[at]) != "--"; ++at) own.emplace_back(words[at]);
  line.output.command_line = without_output_options(own);
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
  add_solid_options(app, line.solid);
  // These are flags of `reference`; given here, they get an error that says so.
  for (const char* flag : {"--fix-x", "--fix-y", "--fix-z"}) app.get_option(flag)->group("");
  add_outputs(app, line);
  add_model_options(app, line);
  add_fit(app, line);
  add_import(app, line);
  add_solver_options(app, line);
  app.add_flag("--json", line.output.json, "print one JSON object on stdout");

  if (!vectors_are_words(own, "--load-force")) return wrong;
  if (const std::optional<int> code = parse(app, own)) return *code;
  line.config_path = config_path(app);
  if (!check_options(app, own, line)) return wrong;
  line.settings = app.config_to_str(true);
  line.mass_given = app.get_option("--mass")->count() > 0;
  return line;
}

namespace {

void require_known_flags(const CommandLine& line) {
  for (const auto& selectors : line.solid.fix_axis)
    if (!selectors.empty())
      throw Failure({ErrorKind::kUsage,
                     "--fix-x, --fix-y and --fix-z are for `tremolo-precompute reference`: a basis "
                     "holds vertices with --fix only"});
}

LocalResponseRequest read_response(const std::vector<std::string>& texts) {
  LocalResponseRequest request;
  for (const std::string& text : texts)
    if (text == "load")
      request.at_load = true;
    else
      request.at.push_back(unwrap(parse_selector(text)));
  return request;
}

SolveRequest read_solve(const CommandLine& line) {
  SolveRequest request = line.solve;
  for (const LinearSolver each :
       {LinearSolver::kCholmod, LinearSolver::kMumps, LinearSolver::kIterative})
    if (line.solver == name_of(each)) request.solver = each;
  if (line.memory > 0) request.memory = static_cast<double>(line.memory);
  return request;
}

PrecomputeRequest read_precompute(const CommandLine& line, const OutputRequest& output) {
  PrecomputeRequest request;
  request.solid = read_problem_request(line.solid);
  request.basis = line.basis;
  request.response = read_response(line.response_at);
  request.solve = read_solve(line);
  request.checkpoint = line.checkpoint;
  request.checkpoint.keep = line.checkpoint.keep || line.checkpoint.resume;
  request.checkpoint.folder = checkpoint_folder(output.basis);
  if (!line.fit.measured.empty()) request.fit = line.fit;
  request.output = output;
  check_request(request);
  return request;
}

}  // namespace

Command read_command(const CommandLine& line) {
  require_known_flags(line);
  OutputRequest output = line.output;
  output.encoding = line.encoding == "compact" ? BasisEncoding::kCompact : BasisEncoding::kFull;
  if (!line.select.empty())
    return SelectRequest{read_problem_request(line.solid, false),
                         unwrap(parse_selector(line.select)), output.preview, output.basis};
  if (!line.import_basis.empty() && !output.basis.empty()) {
    ImportRequest request{read_problem_request(line.solid), line.import_basis, line.import_cubic,
                          line.mass_given, output};
    request.solid.imported = true;
    return request;
  }
  if (!output.basis.empty() || !line.fit.measured.empty() || output.sensitivities)
    return read_precompute(line, output);
  PreviewRequest request{read_problem_request(line.solid), output.preview};
  request.solid.imported = !line.import_basis.empty();
  return request;
}

}  // namespace tremolo
