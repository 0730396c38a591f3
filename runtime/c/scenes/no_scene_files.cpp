// runtime/tremolo_scene.h without scene files: a library that was built without the programs.
#include "runtime/c/scene_c_api.h"

namespace {

tremolo_status refuse() noexcept {
  return tremolo::c_api::fail(TREMOLO_SYSTEM,
                              "this library was built without scene files, which need toml++");
}

}  // namespace

tremolo_status tremolo_scene_read(const char* path, tremolo_scene** scene) {
  (void)path;
  (void)scene;
  return refuse();
}

tremolo_status tremolo_scene_parse(const char* text, const char* path, tremolo_scene** scene) {
  (void)text;
  (void)path;
  (void)scene;
  return refuse();
}
