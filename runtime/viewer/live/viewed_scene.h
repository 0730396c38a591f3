// What the viewer was given: a basis file, a scene of single bodies or a world -> one scene.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "common/result.h"
#include "formats/file/output_guard.h"
#include "runtime/program/run/run_options.h"
#include "runtime/scene/scene.h"
#include "runtime/scene/scene_world.h"

namespace tremolo {

// file: as the user named it. text: of the scene file, if it is a world. starts: of each body its
// --start, mostly empty. inputs: all files that were or will be read.
struct ViewedScene {
  std::string file;
  std::string text;
  Scene scene;
  std::vector<std::string> starts;
  std::vector<NamedFile> inputs = {};
};

// The command line. flags: as they were parsed. told: which of them were given, by their long name.
// onto: parses them onto what a scene says of a body.
struct ViewFlags {
  RunOptions flags;
  std::function<bool(const char*)> told;
  std::function<void(RunOptions&)> onto;
};

// A single body, of a basis file or of a scene without [[bodies]], keeps its load (a model without
// a load of its own has none unless one is told); several of them must have one step. Errors: those
// of scene files; kUsage for --deflect, and for what apply_flags() refuses of a world; kContent for
// a value out of range.
Result<ViewedScene> read_viewed_scene(const std::string& file, const ViewFlags& flags);

// Models that were loaded, so that a world can be begun anew without reading them again.
class ModelCache {
 public:
  // As load_scene_model(). The cache must outlive the source.
  ModelSource source();

 private:
  std::map<std::tuple<std::string, int, bool, bool>, Model::Pointer> models_;
};

}  // namespace tremolo
