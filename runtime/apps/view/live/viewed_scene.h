// Reads the viewer's input, a basis file, a scene of single bodies or a world, as one scene.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "common/result.h"
#include "formats/file/output_guard.h"
#include "runtime/apps/tremolo/run/run_options.h"
#include "runtime/bodies/cloth/cloth_scene.h"
#include "runtime/bodies/tets/scene/tet_scene.h"
#include "runtime/scene/scene.h"
#include "runtime/world/scene_world.h"

namespace tremolo {

// file: as the user named it. text: of the scene file, if it is a world. starts: of each body its
// --start, mostly empty. inputs: all files that were or will be read. tets, cloths: the guests of a
// world.
struct ViewedScene {
  std::string file;
  std::string text;
  Scene scene;
  std::vector<std::string> starts;
  std::vector<NamedFile> inputs = {};
  std::vector<TetSceneBody> tets = {};
  std::vector<ClothSceneBody> cloths = {};

  bool has_guests() const { return !tets.empty() || !cloths.empty(); }
};

// Gravity, step and names of all that is shown: the bodies of the scene as they are, then its
// guests, with their names alone.
Scene shown_scene(const ViewedScene& viewed);

// A single body, of a basis file or of a scene without [[bodies]], keeps its load; without --load,
// a model that has no default load has none. Several such bodies must have one step. Errors: those
// of scene files; kUsage for --deflect, and as for apply_flags() for a world; kContent for a value
// out of range.
Result<ViewedScene> read_viewed_scene(const std::string& file, const GivenFlags& flags);

// A cache of loaded models, so that a world can restart without reading them again.
class ModelCache {
 public:
  // As load_scene_model(). The cache must outlive the source.
  ModelSource source();

 private:
  std::map<std::tuple<std::string, int, bool, bool>, Model::Pointer> models_;
};

}  // namespace tremolo
