// What `tremolo-first` answers where `tremolo` has other kinds of body, worlds, and response
// curves: the program for basis files alone, which ./demo builds first.
#include <CLI/CLI.hpp>

#include "formats/file/command_words.h"
#include "runtime/apps/tremolo/nodal_scenes.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/response/response_commands.h"
#include "runtime/apps/tremolo/world/world_commands.h"

namespace tremolo {
namespace {

Error left_out() {
  return usage_error(
      "this program runs, inspects and exports basis files, alone or in a scene of one table each; "
      "for all else: cmake --build --preset release --target tremolo");
}

int refuse() {
  return report_error(left_out());
}

}  // namespace

int run_cloth_scene(const std::string&, const SceneCommand&) {
  return refuse();
}

int run_tets_scene(const std::string&, const SceneCommand&) {
  return refuse();
}

int inspect_cloth_scene(const std::string&, const SceneCommand&) {
  return refuse();
}

int inspect_tets_scene(const std::string&, const SceneCommand&) {
  return refuse();
}

Result<MotionSource> cloth_source(const std::string&, const SceneCommand&) {
  return left_out();
}

Result<MotionSource> tets_source(const std::string&, const SceneCommand&) {
  return left_out();
}

Result<MixedFile> parse_mixed(std::string_view, const std::string&) {
  return left_out();
}

Status apply_flags(const GivenFlags&, MixedFile&) {
  return left_out();
}

int run_world_command(const MixedFile&, unsigned, bool) {
  return refuse();
}

int inspect_world_command(const MixedFile&, bool) {
  return refuse();
}

int inspect_bodies_command(const std::vector<BodyScene>&, bool) {
  return refuse();
}

MotionSource world_motion(MixedFile) {
  return {};
}

void add_response_flags(CLI::App& app, ResponseOptions&) {
  app.allow_extras();
}

void add_backbone_flags(CLI::App& app, BackboneOptions&) {
  app.allow_extras();
}

int response_command(const ResponseOptions&) {
  return refuse();
}

int backbone_command(const BackboneOptions&) {
  return refuse();
}

}  // namespace tremolo
