#include "runtime/apps/view/live/viewed_scene.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "formats/file/input_file.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/run/run_files.h"
#include "runtime/apps/tremolo/world/world_commands.h"
#include "runtime/io/scenes/nodal_readers.h"
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

Status refuse_trials(const BodyScene& scene) {
  if (!scene.deflect.empty())
    return usage_error(
        "--deflect is found by trial runs, which `tremolo run` makes: give the factor that it "
        "prints as --scale");
  if (!scene.rescale.empty())
    return usage_error(
        "--rescale applies only to `tremolo run` and `export`: write the model with `tremolo "
        "export MODEL "
        "--rescale ... --rescaled FILE` and view that");
  return Success{};
}

// Puts the bodies into one scene, in which names are those that a scene file may have.
Result<ViewedScene> scene_of(const std::vector<BodyScene>& bodies, const std::string& file) {
  ViewedScene viewed;
  viewed.file = file;
  viewed.scene.step = bodies.front().step();
  viewed.scene.duration = bodies.front().file.scene.duration;
  for (const BodyScene& one : bodies) {
    if (one.step() != viewed.scene.step)
      return content_error(file + ": bodies that are seen together have one step: say --step");
    if (Status s = refuse_trials(one); !s) return s.error();
    SceneBody body = one.body();
    body.name = scene_name(body.name);
    if (one.load().signal.kind == SignalKind::kNone) body.loads.clear();
    viewed.scene.bodies.push_back(std::move(body));
    viewed.starts.push_back(one.start);
    for (NamedFile& input : inputs_of(one)) viewed.inputs.push_back(std::move(input));
  }
  return viewed;
}

Result<ViewedScene> single_bodies(const std::string& text, const std::string& file,
                                  const GivenFlags& flags) {
  const Result<std::vector<BodyScene>> bodies = body_scenes(text, flags, file);
  if (!bodies) return bodies.error();
  return scene_of(*bodies, file);
}

// The default load is dropped for a model without one.
Result<ViewedScene> basis_file(const std::string& file, const GivenFlags& flags) {
  Result<std::vector<BodyScene>> bodies = model_scene(file, flags);
  if (!bodies) return bodies.error();
  SceneLoad& load = bodies->front().load();
  if (load.at.empty() && !load.table && !flags.given("--load")) {
    const Result<Model::Pointer> model = load_model(bodies->front());
    if (!model) return model.error();
    if ((*model)->default_load().vertices.empty()) load.signal.kind = SignalKind::kNone;
  }
  return scene_of(*bodies, file);
}

}  // namespace

Result<ViewedScene> read_viewed_scene(const std::string& file, const GivenFlags& flags) {
  if (fs::path(file).extension() != ".toml") return basis_file(file, flags);
  Result<std::string> text = read_whole_file(file);
  if (!text) return text.error();
  const Result<bool> world = is_world(*text, file);
  if (!world) return world.error();
  if (!*world) return single_bodies(*text, file, flags);
  Result<MixedFile> read = parse_mixed(*text, file);
  if (!read) return read.error();
  if (Status s = apply_flags(flags, *read); !s) return s.error();
  const Scene& scene = read->file.scene;
  return ViewedScene{file,
                     std::move(*text),
                     scene,
                     std::vector<std::string>(scene.bodies.size()),
                     inputs_of(*read),
                     std::move(read->tets),
                     std::move(read->cloths)};
}

Scene shown_scene(const ViewedScene& viewed) {
  Scene shown = viewed.scene;
  for (const TetSceneBody& body : viewed.tets) shown.bodies.emplace_back().name = body.name;
  for (const ClothSceneBody& body : viewed.cloths) shown.bodies.emplace_back().name = body.name();
  return shown;
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
