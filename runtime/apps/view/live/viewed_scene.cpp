#include "runtime/apps/view/live/viewed_scene.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <utility>

#include "formats/file/input_file.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/run/run_files.h"
#include "runtime/apps/tremolo/start/start_state.h"
#include "runtime/apps/tremolo/world/world_commands.h"
#include "runtime/io/scenes/csv_rows.h"
#include "runtime/io/scenes/scene_reader.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

// A name that a scene file may have.
std::string scene_name(std::string name) {
  for (char& c : name) {
    const bool good = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                      c == '_' || c == '-' || c == '.';
    if (!good) c = '_';
  }
  if (name.empty() || name.front() == '.') name.insert(0, "body");
  return name;
}

Result<std::vector<SceneLoad>> load_of(const RunOptions& options) {
  SceneLoad load;
  load.at = options.at;
  load.scale = options.scale;
  if (!options.force.empty())
    if (Status s = take(load.force, parse_force(options.force)); !s) return s.error();
  if (!options.signal.empty()) {
    Result<SignalTable> table = read_signal(options.signal);
    if (!table) return table.error();
    load.table = std::make_shared<const SignalTable>(std::move(*table));
    load.signal = {.kind = SignalKind::kTable};
  } else if (Status s = take(load.signal, shaped_signal(options)); !s) {
    return s.error();
  }
  if (load.signal.kind == SignalKind::kNone) return std::vector<SceneLoad>{};
  return std::vector<SceneLoad>{std::move(load)};
}

Result<SceneBody> body_of(const RunOptions& options) {
  if (!options.deflect.empty())
    return usage_error(
        "--deflect is found by trial runs, which `tremolo run` makes: give the factor that it "
        "prints as --scale");
  if (!options.rescale.empty())
    return usage_error(
        "--rescale applies only to `tremolo run` and `export`: write the model with `tremolo "
        "export MODEL "
        "--rescale ... --rescaled FILE` and view that");
  if (Status s = check_run(options); !s) return s.error();
  SceneBody body;
  body.name = scene_name(options.name);
  body.model = options.model;
  body.model_options = {options.modes, options.linear, options.hull};
  body.integrator = options.integrator;
  if (Status s = take(body.options, integrator_options(options)); !s) return s.error();
  if (Status s = take(body.loads, load_of(options)); !s) return s.error();
  return body;
}

Result<ViewedScene> scene_of(const std::vector<RunOptions>& bodies, const std::string& file) {
  ViewedScene viewed;
  viewed.file = file;
  viewed.scene.step = bodies.front().step;
  viewed.scene.duration = bodies.front().duration;
  for (const RunOptions& options : bodies) {
    if (options.step != viewed.scene.step)
      return content_error(file + ": bodies that are seen together have one step: say --step");
    Result<SceneBody> body = body_of(options);
    if (!body) return body.error();
    viewed.scene.bodies.push_back(std::move(*body));
    viewed.starts.push_back(options.start);
    for (NamedFile& input : inputs_of(options)) viewed.inputs.push_back(std::move(input));
  }
  return viewed;
}

Result<ViewedScene> single_bodies(const std::string& text, const std::string& file,
                                  const ViewFlags& flags) {
  Result<std::vector<RunOptions>> bodies = parse_scene(text, file);
  if (!bodies) return bodies.error();
  for (RunOptions& body : *bodies) {
    flags.onto(body);
    // A flag overrides the scene's keys for the same quantity.
    if (flags.told("--load")) body.signal.clear();
    if (flags.told("--scale")) body.deflect.clear();
  }
  return scene_of(*bodies, file);
}

// The default load is dropped for a model without one.
Result<ViewedScene> basis_file(const std::string& file, const ViewFlags& flags) {
  RunOptions options = flags.flags;
  options.model = file;
  options.name = fs::path(file).stem().string();
  if (options.at.empty() && !flags.told("--load") && options.signal.empty()) {
    const Result<Model::Pointer> model = load_model(options);
    if (!model) return model.error();
    if ((*model)->default_load().vertices.empty()) options.load = "none";
  }
  return scene_of({options}, file);
}

}  // namespace

Result<ViewedScene> read_viewed_scene(const std::string& file, const ViewFlags& flags) {
  if (fs::path(file).extension() != ".toml") return basis_file(file, flags);
  Result<std::string> text = read_whole_file(file);
  if (!text) return text.error();
  const Result<bool> world = is_world(*text, file);
  if (!world) return world.error();
  if (!*world) return single_bodies(*text, file, flags);
  Result<SceneFile> read = parse_world(*text, file);
  if (!read) return read.error();
  if (Status s = apply_flags(flags.flags, flags.told, *read); !s) return s.error();
  return ViewedScene{file, std::move(*text), read->scene,
                     std::vector<std::string>(read->scene.bodies.size()), inputs_of(*read)};
}

ModelSource ModelCache::source() {
  return [this](const SceneBody& body) -> Result<Model::Pointer> {
    const ModelOptions& options = body.model_options;
    Model::Pointer& model = models_[{body.model, options.modes, options.linear, options.hull}];
    if (!model)
      if (Status s = take(model, load_scene_model(body)); !s) return s.error();
    return model;
  };
}

}  // namespace tremolo
