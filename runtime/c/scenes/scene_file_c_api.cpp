// runtime/tremolo_scene.h: scene files. Apart from the engine, which knows no TOML.
#include <memory>
#include <string>
#include <utility>

#include "formats/file/input_file.h"
#include "runtime/c/scene_c_api.h"
#include "runtime/io/scenes/nodal_readers.h"

namespace {

using tremolo::Status;
using tremolo::Success;
using tremolo::c_api::with_all;

Status take_scene(const std::string& text, const std::string& path, tremolo_scene** scene) {
  tremolo::Result<tremolo::MixedFile> read = tremolo::parse_mixed(text, path);
  if (!read) return read.error();
  auto made = std::make_unique<tremolo_scene>();
  made->path = path;
  made->scene = std::move(read->file.scene);
  made->tets = std::move(read->tets);
  made->cloths = std::move(read->cloths);
  if (!made->cloths.empty()) made->around = made->cloths.front().scene;
  made->around.integrator = tremolo::ClothScene().integrator;
  made->around.options = {};
  made->around.options.step = made->scene.step;
  made->around.gravity = made->scene.gravity;
  *scene = made.release();
  return Success{};
}

}  // namespace

tremolo_status tremolo_scene_read(const char* path, tremolo_scene** scene) {
  return with_all({{path, "the path"}, {scene, "the place for the scene"}}, [&]() -> Status {
    const tremolo::Result<std::string> text = tremolo::read_whole_file(path);
    if (!text) return text.error();
    return take_scene(*text, path, scene);
  });
}

tremolo_status tremolo_scene_parse(const char* text, const char* path, tremolo_scene** scene) {
  return with_all({{text, "the text"}, {path, "the path"}, {scene, "the place for the scene"}},
                  [&] { return take_scene(text, path, scene); });
}
