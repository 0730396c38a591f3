#include "runtime/apps/tremolo/command_line.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/processor.h"
#include "formats/file/command_words.h"
#include "formats/file/input_file.h"
#include "formats/file/output_guard.h"
#include "runtime/apps/tremolo/export/export.h"
#include "runtime/apps/tremolo/nodal_scenes.h"
#include "runtime/apps/tremolo/output/plot.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/response/response_commands.h"
#include "runtime/apps/tremolo/run/run_options.h"
#include "runtime/apps/tremolo/run/simulate.h"
#include "runtime/apps/tremolo/world/world_commands.h"
#include "runtime/integrator.h"
#include "runtime/io/scenes/scene_keys.h"
#include "runtime/io/scenes/scene_reader.h"

namespace tremolo {
namespace {

// Adds the flags of a body's load, start and integrator.
void add_motion_flags(CLI::App& run, RunOptions& o) {
  add_body_flags(run, o);
  run.add_option("--duration", o.duration, "simulated time, s")->capture_default_str();
}

void add_run_flags(CLI::App& run, RunOptions& o) {
  add_motion_flags(run, o);
  add_modes_flag(run, o);
  run.add_option(
      "--probe", o.probes,
      "record the displacement of this vertex, or of those of a selector; may be repeated");
  run.add_option("--coordinate", o.coordinates,
                 "record this q, a range as in 0-5, or all; may be repeated");
  run.add_flag("--velocities", o.velocities, "record velocities of these too");
  run.add_option("--out", o.out, "directory for run.csv, report.json, plots and surfaces");
  run.add_option("--every", o.every, "a CSV row every so many steps")->capture_default_str();
  run.add_flag("--plot", o.plot, "draw energy.html");
  run.add_option("--surfaces", o.surfaces, "write so many surfaces, evenly spaced in time");
  run.add_option(
      "--wav", o.wav,
      "sound of what the body does, 48 000 samples a second with as many steps each as its "
      "modes need; with --step a step a sample");
  run.add_option("--listen", o.listen,
                 "with --wav: vertex or selector whose acceleration along the normal is heard");
  run.add_option("--surface-format", o.surface_format, "ply, obj or inc (POV-Ray)")
      ->check(CLI::IsMember({"ply", "obj", "inc"}))
      ->capture_default_str();
}

void add_export_flags(CLI::App& app, ExportOptions& o) {
  app.add_option("file", o.model, "basis file, or scene.toml for what moves")->required();
  app.add_option("--cub", o.cub, "VegaFEM's reduced forces, .cub");
  app.add_option("--U", o.u,
                 "VegaFEM's basis, .U, over all vertices in the mesh's order. Tremolo's is "
                 "orthonormal in the consistent mass unless it was made with --mass lumped");
  app.add_option("--vtu", o.vtu,
                 "the modes as point data of the surface, .vtu (tremolo-precompute --modes-vtu "
                 "writes them on the tetrahedra)");
  app.add_option("--rescaled", o.rescaled,
                 "a basis file of the same body of another material, which --rescale gives");
  app.add_option("--light", o.light,
                 "a basis file of the same body without the vertices inside, for pages and games");
}

void add_motion_outputs(CLI::App& app, MotionOutputs& o) {
  app.add_option("--glb", o.glb, "glTF: modes as morph targets, their weights over time, poses");
  app.add_option("--pc2", o.pc2,
                 "point cache of Blender and 3ds Max, the rest shape .obj beside it");
  app.add_option("--mdd", o.mdd, "the same as MDD");
  app.add_option("--pvd", o.pvd, "ParaView's list of .vtu files, which lie in a folder beside it");
  app.add_option("--usda", o.usda, "USD as text");
  app.add_option("--series", o.series, "numbered surfaces, OUT.ply or OUT.obj");
  app.add_option("--page", o.page, "a page, .html, on which it plays; it needs no other file");
  app.add_option("--runs", o.extras.runs,
                 "of a page: folders of tremolo run --out, whose energies and figures it shows");
  app.add_option("--note", o.extras.note, "of a page: a paragraph below the motion");
  app.add_option("--live", o.extras.live,
                 "of a page: the page of the live engine, which it shows first");
  app.add_option("--rate", o.range.rate, "frames a second; a frame is the nearest step")
      ->capture_default_str();
  app.add_option("--from", o.range.from, "the first frame's time, s")->capture_default_str();
  app.add_option("--to", o.range.to, "s (default: the end of the run)");
  app.add_option("--modes", o.modes,
                 "keep the first R coordinates in the files only (0: all); all of them move")
      ->check(CLI::Range(0, 1'000'000));
  app.add_flag(
      "--plain-weights", o.plain_weights,
      "of a .glb: weights are q itself, which programs that clamp them to [0, 1] get wrong");
  CLI::Option* none = app.add_flag("--no-normals", o.no_normals,
                                   "of a .glb: half as large; viewers make normals up");
  app.add_option("--normal-targets", o.normal_targets,
                 "of a .glb: so many more morph targets, of normals alone, which follow strong "
                 "bending")
      ->check(CLI::Range(0, 256))
      ->excludes(none);
  app.add_flag("--no-colliders", o.no_colliders, "leave the scene's colliders out");
  app.add_option("--texture", o.textures,
                 "of a .glb: [MATERIAL=]IMAGE, a .png or .jpg; may be repeated");
  app.add_option("--up", o.up, "the world's axis that points up")
      ->check(CLI::IsMember({"y", "z"}))
      ->capture_default_str();
  app.add_option("--beside", o.beside, "of cloth: a second scene, beside the first");
  app.add_flag("--json", o.json, "print one JSON object on stdout");
}

struct Request {
  ExportOptions exported;
  MotionOutputs motion;
  ResponseOptions response;
  BackboneOptions backbone;
  std::string file;
  std::string select;
  bool json = false;
  unsigned threads = 1;
  std::string degree;
  std::vector<std::string> directories;
  std::string picture;
};

// The commands with their flags; request and options must outlive it.
struct Parser {
  CLI::App app{
      "Deformable solids that vibrate in real time without losing their energy. SI units."};
  CLI::App* inspect = nullptr;
  CLI::App* run = nullptr;
  CLI::App* plot = nullptr;
  CLI::App* response = nullptr;
  CLI::App* backbone = nullptr;
  CLI::App* exporter = nullptr;
  CLI::App* bench = nullptr;
  CLI::App* reproduce = nullptr;
  CLI::App* view = nullptr;

  Parser(Request& request, RunOptions& options) {
    app.name("tremolo");
    app.set_version_flag("--version", std::string("tremolo ") + TREMOLO_VERSION);
    app.require_subcommand(1);
    inspect = app.add_subcommand(
        "inspect", "show what a basis file holds, or where the bodies of a scene are at its start");
    inspect->add_option("file", request.file, "basis file, or scene.toml")->required();
    inspect->add_option("--select", request.select,
                        "print the boundary's vertices that a selector chooses, and nothing else");
    inspect->add_flag("--json", request.json, "print one JSON object on stdout");
    run = app.add_subcommand("run", "integrate a model or a scene");
    run->add_option("file", request.file, "basis file, or scene.toml")->required();
    run->add_flag("--json", request.json, "print one JSON object on stdout");
    run->add_option("--save", options.save, "file of the whole state at the end");
    run->add_option("--restore", options.restore, "begin in the state that --save wrote");
    run->add_option("--threads", request.threads,
                    "threads that step the bodies, 0: one per core; one body takes one")
        ->check(CLI::Range(0U, kMostThreads))
        ->capture_default_str();
    run->add_option("--degree", request.degree,
                    "of bodies of kind tets: linear, quadratic or adaptive");
    add_run_flags(*run, options);
    plot = app.add_subcommand("plot",
                              "energy over time of several runs on one page or in one picture");
    plot->add_option("runs", request.directories, "directories of tremolo run --out")->required();
    plot->add_option("-o,--output", request.picture, "page, .html")->required();
    response = app.add_subcommand(
        "response",
        "the periodic motions under a periodic load over its frequency, and their "
        "stability");
    add_response_flags(*response, request.response);
    backbone = app.add_subcommand(
        "backbone", "the free periodic motions of a mode: frequency over amplitude and energy");
    add_backbone_flags(*backbone, request.backbone);
    exporter = app.add_subcommand(
        "export", "write a model, or what it does, in files that other programs open");
    add_export_flags(*exporter, request.exported);
    add_motion_outputs(*exporter, request.motion);
    add_motion_flags(*exporter, options);
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

// Replaces this process by another program of the same folder, with the same arguments. task: its
// purpose; how: the way to build it; both are for the error. Returns only if it cannot be started.
int start_beside(const char* program, const std::string& task, const char* how, char** words) {
  std::error_code error;
  const std::filesystem::path here = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string path = (here.parent_path() / program).string();
  ::execv(path.c_str(), words);
  const std::string why =
      errno == ENOENT ? std::string("it has not been built: ") + how : std::strerror(errno);
  return report_error(system_error(task + " is what " + path + " is for; " + why));
}

int start_laboratory(char** words) {
  return start_beside("tremolo-lab", "`" + std::string(words[1]) + "`",
                      "cmake --build --preset release --target tremolo-lab", words);
}

int start_viewer(char** words) {
  return start_beside("tremolo-view", "`view`",
                      "cmake --preset release -DTREMOLO_BUILD_VIEWER=ON && "
                      "cmake --build --preset release --target tremolo-view",
                      words);
}

Status refuse_degree(const Request& request) {
  if (request.degree.empty()) return Success{};
  return usage_error("--degree applies only to bodies of kind \"tets\"");
}

// Returns the test of whether a flag was given. command: must outlive the result.
std::function<bool(const char*)> told_flags(const CLI::App& command) {
  return [&command](const char* flag) {
    // `export --modes` limits the coordinates in the file, not those of the motion.
    if (command.get_name() == "export" && std::string_view(flag) == "--modes") return false;
    const CLI::Option* option = command.get_option_no_throw(flag);
    return option != nullptr && option->count() > 0;
  };
}

// Reads a scene with [[bodies]] and applies the flags.
Result<MixedFile> world_of(const std::string& text, const SceneCommand& command) {
  Result<MixedFile> file = parse_mixed(text, command.file);
  if (!file) return file.error();
  if (Status s = apply_flags(command.flags, *file); !s) return s.error();
  return file;
}

int run_world_scene(const std::string& text, const Request& request, const SceneCommand& command) {
  const Result<MixedFile> mixed = world_of(text, command);
  if (!mixed) return report_error(mixed.error());
  return run_world_command(*mixed, request.threads, request.json);
}

bool is_scene(const std::string& path) {
  return std::filesystem::path(path).extension() == ".toml";
}

int run_bodies(const Result<std::vector<BodyScene>>& bodies, const Request& request) {
  return bodies ? run_command(*bodies, request.threads, request.json)
                : report_error(bodies.error());
}

int run_scene(const Request& request, const SceneCommand& command) {
  const Result<std::string> text = read_whole_file(command.file);
  if (!text) return report_error(text.error());
  const Result<SceneKind> kind = scene_kind(*text, command.file);
  if (!kind) return report_error(kind.error());
  if (*kind == SceneKind::kCloth) return run_cloth_scene(*text, command);
  if (*kind == SceneKind::kTets) return run_tets_scene(*text, command);
  if (Status s = refuse_degree(request); !s) return report_error(s.error());
  if (*kind == SceneKind::kWorld) return run_world_scene(*text, request, command);
  return run_bodies(body_scenes(*text, command.flags, command.file), request);
}

// The motion that `tremolo export` records, of a scene.
Result<MotionSource> scene_motion(const SceneCommand& command) {
  const Result<std::string> text = read_whole_file(command.file);
  if (!text) return text.error();
  const Result<SceneKind> kind = scene_kind(*text, command.file);
  if (!kind) return kind.error();
  if (*kind == SceneKind::kCloth) return cloth_source(*text, command);
  if (!command.beside.empty()) return usage_error("--beside applies only to scenes of cloth");
  if (*kind == SceneKind::kTets) return tets_source(*text, command);
  if (*kind == SceneKind::kWorld) {
    Result<MixedFile> file = world_of(*text, command);
    if (!file) return file.error();
    return world_motion(std::move(*file));
  }
  Result<std::vector<RunOptions>> tables = parse_scene(*text, command.file);
  if (!tables) return tables.error();
  // Their files are those of `tremolo run`.
  for (RunOptions& table : *tables) {
    table.out.clear();
    table.surfaces = 0;
    table.plot = false;
  }
  Result<std::vector<BodyScene>> bodies =
      body_scenes(std::move(*tables), command.flags, command.file);
  if (!bodies) return bodies.error();
  return bodies_motion(std::move(*bodies));
}

Result<MotionSource> model_motion(const SceneCommand& command) {
  if (!command.beside.empty()) return usage_error("--beside applies only to scenes of cloth");
  Result<std::vector<BodyScene>> bodies = model_scene(command.file, command.flags);
  if (!bodies) return bodies.error();
  return bodies_motion(std::move(*bodies));
}

int run_export(const Request& request, const RunOptions& flags, const CLI::App& app) {
  ExportOptions still = request.exported;
  still.rescale = flags.rescale;
  const bool asks_still = still.any();
  if (asks_still && is_scene(still.model))
    return report_error(usage_error(
        "--cub, --U, --vtu, --light and --rescaled apply only to a basis file, not to a scene"));
  const MotionOutputs& moved = request.motion;
  if (Status s = keep_apart({still.cub, still.u, still.vtu, still.light, moved.glb, moved.pc2,
                             moved.mdd, moved.pvd, moved.usda, moved.series, moved.page},
                            {});
      !s)
    return report_error(s.error());
  if (asks_still || !moved.any())
    if (const int code = export_command(still); code != 0) return code;
  if (!moved.any()) return 0;
  const SceneCommand command = {
      still.model, {flags, told_flags(app)}, {}, moved.json, moved.beside};
  const Result<MotionSource> source =
      is_scene(still.model) ? scene_motion(command) : model_motion(command);
  return source ? export_motion_command(moved, *source) : report_error(source.error());
}

int inspect_scene(const Request& request) {
  const Result<std::string> text = read_whole_file(request.file);
  if (!text) return report_error(text.error());
  const Result<SceneKind> kind = scene_kind(*text, request.file);
  if (!kind) return report_error(kind.error());
  if (!request.select.empty())
    return report_error(usage_error("--select applies only to a basis file, not to a scene"));
  const auto no_flags = [](const char*) { return false; };
  const SceneCommand command = {request.file, {{}, no_flags}, {}, request.json};
  if (*kind == SceneKind::kCloth) return inspect_cloth_scene(*text, command);
  if (*kind == SceneKind::kTets) return inspect_tets_scene(*text, command);
  if (*kind == SceneKind::kWorld) {
    const Result<MixedFile> file = parse_mixed(*text, request.file);
    return file ? inspect_world_command(*file, request.json) : report_error(file.error());
  }
  const Result<std::vector<BodyScene>> bodies = body_scenes(*text, command.flags, command.file);
  return bodies ? inspect_bodies_command(*bodies, request.json) : report_error(bodies.error());
}

int run_program(int count, char** words) {
  Request request;
  RunOptions options;
  Parser parser(request, options);
  if (const std::optional<int> code = read_words(parser.app, count, words)) return *code;
  if (*parser.inspect && is_scene(request.file)) return inspect_scene(request);
  if (*parser.inspect) return inspect_command(request.file, request.select, request.json);
  if (*parser.plot) return plot_command(request.directories, request.picture);
  if (*parser.response) return response_command(request.response);
  if (*parser.backbone) return backbone_command(request.backbone);
  if (*parser.exporter) return run_export(request, options, *parser.exporter);
  if (*parser.bench || *parser.reproduce) return start_laboratory(words);
  if (*parser.view) return start_viewer(words);
  const SceneCommand command = {
      request.file, {options, told_flags(*parser.run)}, request.degree, request.json};
  if (is_scene(request.file)) return run_scene(request, command);
  if (Status s = refuse_degree(request); !s) return report_error(s.error());
  return run_bodies(model_scene(command.file, command.flags), request);
}

}  // namespace

int run_command_line(int count, char** words) {
  return run_guarded([&] { return run_program(count, words); });
}

}  // namespace tremolo
