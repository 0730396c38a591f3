#include "runtime/apps/tremolo/nodal_scenes.h"

#include <utility>
#include <vector>

#include "formats/file/input_file.h"
#include "runtime/apps/tremolo/cloth/cloth_commands.h"
#include "runtime/apps/tremolo/output/tell.h"
#include "runtime/apps/tremolo/tets/tets_commands.h"

namespace tremolo {
namespace {

Result<ClothFile> cloths_of(const std::string& text, const SceneCommand& command) {
  Result<ClothFile> file = parse_cloths(text, command.file);
  if (!file) return file.error();
  if (Status s = apply_cloth_flags(command.flags, *file); !s) return s.error();
  return file;
}

}  // namespace

int run_cloth_scene(const std::string& text, const SceneCommand& command) {
  const Result<ClothFile> file = cloths_of(text, command);
  return file ? run_cloth_command(*file, command.json) : report_error(file.error());
}

int inspect_cloth_scene(const std::string& text, const SceneCommand& command) {
  const Result<ClothFile> file = parse_cloths(text, command.file);
  return file ? inspect_cloth_command(*file, command.json) : report_error(file.error());
}

namespace {

Result<TetScene> tets_of(const std::string& text, const SceneCommand& command) {
  Result<TetScene> scene = parse_tets_scene(text, command.file);
  if (!scene) return scene.error();
  if (Status s = apply_tets_flags(command.flags, command.degree, *scene); !s) return s.error();
  return scene;
}

}  // namespace

int run_tets_scene(const std::string& text, const SceneCommand& command) {
  const Result<TetScene> scene = tets_of(text, command);
  return scene ? run_tets_command(*scene, command.json) : report_error(scene.error());
}

int inspect_tets_scene(const std::string& text, const SceneCommand& command) {
  const Result<TetScene> scene = parse_tets_scene(text, command.file);
  return scene ? inspect_tets_command(*scene, command.json) : report_error(scene.error());
}

Result<MotionSource> cloth_source(const std::string& text, const SceneCommand& command) {
  Result<ClothFile> file = cloths_of(text, command);
  if (!file) return file.error();
  std::vector<ClothFile> files{std::move(*file)};
  if (!command.beside.empty()) {
    SceneCommand second = command;
    second.file = command.beside;
    const Result<std::string> its_text = read_whole_file(second.file);
    if (!its_text) return its_text.error();
    Result<ClothFile> beside = cloths_of(*its_text, second);
    if (!beside) return beside.error();
    files.push_back(std::move(*beside));
  }
  return cloth_motion(std::move(files));
}

Result<MotionSource> tets_source(const std::string& text, const SceneCommand& command) {
  Result<TetScene> scene = tets_of(text, command);
  if (!scene) return scene.error();
  return tets_motion(std::move(*scene));
}

}  // namespace tremolo
