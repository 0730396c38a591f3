// tremolo: inspect a basis file, let it vibrate, plot what happened.
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/file/whole_file.h"
#include "runtime/integrator.h"
#include "runtime/program/export.h"
#include "runtime/program/inspect.h"
#include "runtime/program/output/plot.h"
#include "runtime/program/output/tell.h"
#include "runtime/program/run/run.h"
#include "runtime/program/run/run_flags.h"
#include "runtime/program/world/run_world.h"
#include "runtime/scene_reader/scene_reader.h"

namespace tremolo {
namespace {

void add_run_flags(CLI::App& run, RunOptions& o) {
  add_body_flags(run, o);
  run.add_option("--duration", o.duration, "simulated time, s")->capture_default_str();
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
  std::string file;
  std::string select;
  bool json = false;
  std::string save, restore;
  std::vector<std::string> directories;
  std::string picture;
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
  CLI::App* view = nullptr;

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
    run->add_option("--save", request.save, "of a scene with [[bodies]]: its state at the end");
    run->add_option("--restore", request.restore, "likewise: begin with what --save has written");
    add_run_flags(*run, options);
    plot = app.add_subcommand("plot", "energy over time of several runs in one picture");
    plot->add_option("runs", request.directories, "directories of tremolo run --out")->required();
    plot->add_option("-o,--output", request.picture, ".svg or .png")->required();
    exporter = app.add_subcommand("export", "write a model in the formats of VegaFEM and ParaView");
    add_export_flags(*exporter, request.exported);
    bench = app.add_subcommand("bench", "run time against error and stability of all methods");
    reproduce =
        app.add_subcommand("reproduce", "the thesis's tables and figures, ours beside them");
    view = app.add_subcommand("view", "see and touch the bodies of a model or a scene; pictures");
    for (CLI::App* of_another : {bench, reproduce, view}) {
      of_another->prefix_command();
      of_another->set_help_flag();
    }
  }
};

// Replaces this process by another program, which is installed beside this one, with the same
// arguments. how: to build it. Returns only if that cannot be started.
int start_beside(const char* program, const char* how, char** words) {
  std::error_code error;
  const std::filesystem::path here = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string path = (here.parent_path() / program).string();
  ::execv(path.c_str(), words);
  const std::string why =
      errno == ENOENT ? std::string("it has not been built: ") + how : std::strerror(errno);
  return report_error(
      system_error("`" + std::string(words[1]) + "` is what " + path + " does; " + why));
}

int start_laboratory(char** words) {
  return start_beside("tremolo-lab", "cmake --build --preset release --target tremolo-lab", words);
}

int start_viewer(char** words) {
  return start_beside("tremolo-view",
                      "cmake --preset release -DTREMOLO_BUILD_VIEWER=ON && "
                      "cmake --build --preset release --target tremolo-view",
                      words);
}

std::vector<RunOptions> bodies_of(const Request& request, const RunOptions& flags) {
  RunOptions options = flags;
  options.model = request.file;
  options.name = std::filesystem::path(request.file).stem().string();
  return {options};
}

// Of runs that are no world.
Status check_not_saved(const Request& request) {
  if (request.save.empty() && request.restore.empty()) return Success{};
  return usage_error(
      "--save and --restore are of a scene with [[bodies]]; of a run of one body --coordinate all "
      "--velocities records the states, and --start begins with one of them");
}

// flags: as they were parsed; run: who knows which of them were given.
int run_world_scene(const std::string& text, const Request& request, const RunOptions& flags,
                    const CLI::App& run) {
  Result<SceneFile> file = parse_world(text, request.file);
  if (!file) return report_error(file.error());
  const auto told = [&run](const char* flag) { return run.count(flag) > 0; };
  if (Status s = apply_flags(flags, told, *file); !s) return report_error(s.error());
  file->outputs.save = request.save;
  file->outputs.restore = request.restore;
  return run_world_command(*file, request.json);
}

int run_scene(const std::string& text, int count, char** words, Request& request) {
  Result<std::vector<RunOptions>> bodies = parse_scene(text, request.file);
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
    return code == 0 ? 0 : exit_code(ErrorKind::kUsage);
  }
  if (*parser.inspect) return inspect_command(request.file, request.select, request.json);
  if (*parser.plot) return plot_command(request.directories, request.picture);
  if (*parser.exporter) return export_command(request.exported);
  if (*parser.bench || *parser.reproduce) return start_laboratory(words);
  if (*parser.view) return start_viewer(words);
  if (std::filesystem::path(request.file).extension() != ".toml") {
    if (Status s = check_not_saved(request); !s) return report_error(s.error());
    return run_command(bodies_of(request, options), request.json);
  }
  const Result<std::string> text = read_whole_file(request.file);
  if (!text) return report_error(text.error());
  const Result<bool> world = is_world(*text, request.file);
  if (!world) return report_error(world.error());
  if (*world) return run_world_scene(*text, request, options, *parser.run);
  if (Status s = check_not_saved(request); !s) return report_error(s.error());
  return run_scene(*text, count, words, request);
}

}  // namespace
}  // namespace tremolo

int main(int count, char** words) {
  return tremolo::run_guarded([&] { return tremolo::run_program(count, words); });
}
