// tremolo: inspect a basis file, let it vibrate, plot what happened.
#include <filesystem>
#include <iostream>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/atomic_file.h"
#include "formats/standard_streams.h"
#include "runtime/integrators/integrator.h"
#include "runtime/program/bench/bench.h"
#include "runtime/program/commands.h"
#include "runtime/program/export.h"
#include "runtime/program/reproduce/reproduce.h"

namespace tremolo {
namespace {

void add_run_flags(CLI::App& run, RunOptions& o) {
  run.add_option("--integrator", o.integrator,
                 fmt::format("{}", fmt::join(integrator_names(), ", ")))
      ->capture_default_str();
  run.add_option("--step", o.step, "h, s")->capture_default_str();
  run.add_option("--duration", o.duration, "simulated time, s")->capture_default_str();
  run.add_option("--modes", o.modes, "keep the first R coordinates only (0: all)");
  run.add_flag("--linear", o.linear, "leave the cubic and quartic terms out: not read, not kept");
  CLI::Option* load = run.add_option("--load", o.load,
                                     "impulse (3 ms), square (0.3 s), sine (1 Hz), constant, none")
                          ->capture_default_str();
  run.add_option("--signal", o.signal,
                 "CSV of times (s) and values: the load's course in time instead, straight lines "
                 "between")
      ->excludes(load);
  run.add_option("--at", o.at,
                 "what the load acts on, a vertex's id or a selector (default: the model's)");
  run.add_option("--force", o.force, "with --at: X,Y,Z in N, shared by the vertices");
  CLI::Option* scale =
      run.add_option("--scale", o.scale, "multiplies the load")->capture_default_str();
  run.add_option("--deflect", o.deflect,
                 "5%: scale the load until the largest displacement of the run is this share of "
                 "the size")
      ->excludes(scale);
  run.add_option(
      "--start", o.start,
      "static (standing still under the load at t = 0), VERTEX|SELECTOR=X,Y,Z (displaced "
      "by so many m and let go), or FILE.csv[@T] (a row of a run with --coordinate all "
      "--velocities)");
  run.add_option("--alpha", o.alpha, "Rayleigh damping of the mass, 1/s");
  run.add_option("--beta", o.beta, "Rayleigh damping of the rest stiffness, s");
  run.add_option("--newmark-beta", o.newmark_beta, "Newmark's beta")->capture_default_str();
  run.add_option("--newmark-gamma", o.newmark_gamma, "Newmark's gamma")->capture_default_str();
  run.add_option("--split", o.split, "which coordinates are explicit: default, thesis or a count")
      ->capture_default_str();
  run.add_option("--safety", o.safety, "of the default split: explicit iff h w < 2 safety")
      ->capture_default_str();
  run.add_option("--tolerance", o.tolerance, "of a step's solve, relative")->capture_default_str();
  run.add_option("--max-iterations", o.max_iterations, "of a step's solve")->capture_default_str();
  run.add_option(
      "--probe", o.probes,
      "record the displacement of this vertex, or of those of a selector; may be repeated");
  run.add_option("--coordinate", o.coordinates,
                 "record this q, a range as in 0-5, or all; may be repeated");
  run.add_flag("--velocities", o.velocities, "record velocities of these too");
  run.add_option("--out", o.out, "directory for run.csv, report.json, plots and surfaces");
  run.add_option("--every", o.every, "a CSV row every so many steps")->capture_default_str();
  run.add_flag("--plot", o.plot, "draw energy.svg (needs gnuplot)");
  run.add_option("--surfaces", o.surfaces, "write so many surfaces, evenly spaced in time");
  run.add_option("--surface-format", o.surface_format, "ply, obj or inc (POV-Ray)")
      ->check(CLI::IsMember({"ply", "obj", "inc"}))
      ->capture_default_str();
  run.add_flag("--hull", o.hull, "show the boundary of the tetrahedra, not the render surface");
}

void add_bench_flags(CLI::App& bench, bench::Options& o, bool& quick) {
  bench.add_option("--models", o.models, "a,b,...; default: all six")->delimiter(',');
  bench.add_option("--models-dir", o.models_dir, "where NAME.tremolo are")->capture_default_str();
  bench.add_option("--integrators", o.integrators, "a,b,...; default: all")->delimiter(',');
  bench.add_option("--loads", o.loads, "square, impulse, sine")->delimiter(',');
  bench
      .add_option("--amplitudes", o.amplitudes,
                  "largest displacement of the loaded vertex over the solid's size")
      ->delimiter(',');
  bench.add_option("--steps-ms", o.steps_ms, "steps, ms; each divides 6 ms")->delimiter(',');
  bench.add_option("--duration", o.duration, "simulated time, s")->capture_default_str();
  bench.add_flag("--quick", quick,
                 "beam and horse, square load, two amplitudes, fewer steps: minutes, not hours");
  bench.add_option("--only", o.only, "precision, stability or speed");
  bench.add_option("--out", o.out, "directory for the page and the CSVs")->capture_default_str();
  bench.add_option("--threads", o.threads, "for all but the timing; 0: one a core");
  bench.add_flag("--json", o.json, "print one JSON object on stdout");
}

// What --quick leaves out, unless a flag asks for it.
void shorten(const CLI::App& bench, bench::Options& o) {
  const auto given = [&](const char* flag) { return bench.count(flag) > 0; };
  if (!given("--models")) o.models = {"beam", "horse"};
  if (!given("--loads")) o.loads = {"square"};
  if (!given("--amplitudes")) o.amplitudes = {0.05, 0.15};
  if (!given("--steps-ms")) o.steps_ms = {6, 3, 1.5, 0.75, 0.3};
  o.stability_scales = {1, 10};
  o.stability_steps_ms = {10, 3};
}

void add_reproduce_flags(CLI::App& reproduce, ReproduceOptions& o) {
  reproduce.add_option("--models", o.models, "of the six, comma-separated (default: all)")
      ->delimiter(',');
  reproduce.add_option("--models-dir", o.models_directory, "where their basis files are")
      ->capture_default_str();
  reproduce.add_option("--out", o.out, "directory for index.html and CSVs")->capture_default_str();
  reproduce.add_flag("--long", o.long_form, "experiment 3 over 10 000 s instead of 200 s");
  reproduce.add_option("--threads", o.threads, "for the curves (default: all cores)")
      ->check(CLI::Range(1, 1024));
  reproduce.add_flag("--json", o.json, "print the criteria as one JSON object on stdout");
}

void add_export_flags(CLI::App& app, ExportOptions& o) {
  app.add_option("file", o.model, "basis file")->required();
  app.add_option("--cub", o.cub, "VegaFEM's reduced forces, .cub");
  app.add_option("--U", o.u,
                 "VegaFEM's basis, .U, over all vertices in the mesh's order. Tremolo's is "
                 "orthonormal in the consistent mass unless it was made with --mass lumped");
  app.add_option("--vtu", o.vtu,
                 "the modes as point data of the surface, .vtu (tremolo-precompute --modes-vtu "
                 "writes them on the tetrahedra)");
}

struct Request {
  ExportOptions exported;
  ReproduceOptions reproduce;
  std::string file;
  std::string select;
  bool json = false;
  std::vector<std::string> directories;
  std::string picture;
  bench::Options bench;
  bool quick = false;
};

// The same command line read onto given defaults: flags win over a scene's keys.
struct Parser {
  CLI::App app{
      "Deformable solids that vibrate in real time without losing their energy. SI units."};
  CLI::App* inspect = nullptr;
  CLI::App* run = nullptr;
  CLI::App* plot = nullptr;
  CLI::App* exporter = nullptr;
  CLI::App* bench = nullptr;
  CLI::App* reproduce = nullptr;

  Parser(Request& request, RunOptions& options) {
    app.name("tremolo");
    app.set_version_flag("--version", std::string("tremolo ") + TREMOLO_VERSION);
    app.require_subcommand(1);
    inspect = app.add_subcommand("inspect", "show what a basis file holds, verify its checksums");
    inspect->add_option("file", request.file, "basis file")->required();
    inspect->add_option("--select", request.select,
                        "print the boundary's vertices that a selector chooses, and nothing else");
    inspect->add_flag("--json", request.json, "print one JSON object on stdout");
    run = app.add_subcommand("run", "integrate a model or a scene");
    run->add_option("file", request.file, "basis file, or scene.toml")->required();
    run->add_flag("--json", request.json, "print one JSON object on stdout");
    add_run_flags(*run, options);
    plot = app.add_subcommand("plot", "energy over time of several runs in one picture");
    plot->add_option("runs", request.directories, "directories of tremolo run --out")->required();
    plot->add_option("-o,--output", request.picture, ".svg or .png")->required();
    exporter = app.add_subcommand("export", "write a model in the formats of VegaFEM and ParaView");
    add_export_flags(*exporter, request.exported);
    bench = app.add_subcommand("bench", "run time against error and stability of all methods");
    add_bench_flags(*bench, request.bench, request.quick);
    reproduce =
        app.add_subcommand("reproduce", "the thesis's tables and figures, ours beside them");
    add_reproduce_flags(*reproduce, request.reproduce);
  }
};

std::vector<RunOptions> bodies_of(const Request& request, const RunOptions& flags) {
  RunOptions options = flags;
  options.model = request.file;
  options.name = std::filesystem::path(request.file).stem().string();
  return {options};
}

int run_scene(int count, char** words, Request& request) {
  Result<std::vector<RunOptions>> bodies = read_scene(request.file);
  if (!bodies) return report_error(bodies.error());
  for (RunOptions& body : *bodies) {
    Parser parser(request, body);
    parser.app.parse(count, words);  // cannot fail: it has been parsed before
    // Of two ways to say one thing the flag's wins.
    if (parser.run->count("--load") > 0) body.signal.clear();
    if (parser.run->count("--scale") > 0) body.deflect.clear();
    if (parser.run->count("--deflect") > 0) body.scale = 1.0;
    if (bodies->size() > 1 && !body.out.empty())
      body.out = (std::filesystem::path(body.out) / body.name).string();
  }
  return run_command(*bodies, request.json);
}

int run_program(int count, char** words) {
  Request request;
  RunOptions options;
  Parser parser(request, options);
  try {
    parser.app.parse(count, words);
  } catch (const CLI::ParseError& error) {
    const int code = parser.app.exit(error, std::cout, std::cerr);
    return code == 0 ? 0 : static_cast<int>(ErrorKind::kUsage);
  }
  if (*parser.inspect) return inspect_command(request.file, request.select, request.json);
  if (*parser.plot) return plot_command(request.directories, request.picture);
  if (*parser.exporter) return export_command(request.exported);
  if (*parser.bench) {
    if (request.quick) shorten(*parser.bench, request.bench);
    return bench::run(request.bench);
  }
  if (*parser.reproduce) return reproduce_command(request.reproduce);
  if (std::filesystem::path(request.file).extension() == ".toml")
    return run_scene(count, words, request);
  return run_command(bodies_of(request, options), request.json);
}

}  // namespace
}  // namespace tremolo

int main(int count, char** words) {
  tremolo::hold_standard_streams();
  tremolo::remove_partial_files_on_signals();
  try {
    return tremolo::run_program(count, words);
  } catch (const std::bad_alloc&) {
    return tremolo::report_error(tremolo::system_error("out of memory"));
  } catch (const std::exception& exception) {
    return tremolo::report_error(tremolo::system_error(exception.what()));
  }
}
