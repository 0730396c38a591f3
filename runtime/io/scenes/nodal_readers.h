// Readers of scenes of cloth and of tetrahedra.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "runtime/bodies/cloth/cloth_scene.h"
#include "runtime/bodies/tets/scene/tet_scene.h"
#include "runtime/io/scenes/scene_keys.h"
#include "runtime/io/scenes/scene_reader.h"
#include "runtime/io/scenes/toml_keys.h"

namespace tremolo {

// text: the file's. files: further files of the scene: CSV files of gravity and motions.
struct ClothFile {
  std::string path;
  std::string text;
  ClothScene scene;
  SceneOutputs outputs;
  std::vector<std::string> files;
};

// Meshes and CSV files are relative to the scene file. Errors: kSystem if a file is unreadable;
// kContent with file, line and key for an unknown key or a wrong value, and for errors of
// check_scene.
Result<ClothFile> parse_cloths(std::string_view text, const std::string& path);

// Reads the key `pins` of a cloth whose grid or file has been read: a place, a list of places, or
// tables with `at` (one or several places), `motion` and `until`. A place is a particle's number,
// "near:X,Y,Z" (the nearest particle at rest), or of a grid "corners", "left", "right", "top",
// "bottom", "top-left" and so on: the first row of particles is the bottom, the first column is on
// the left. what: the cloth's name in errors. files: CSV files that were read are added. Errors as
// for parse_cloths.
Status read_pins(TomlKeys& keys, const std::string& path, const std::string& what,
                 std::vector<std::string>& files, SceneCloth& cloth);

// One particle of a cloth, by a place as above. Errors also for places of several.
std::size_t read_particle(TomlKeys& keys, const char* key, const SceneCloth& cloth);

// step, duration: s. gravity: m/s^2.
struct TetScene : TetBodiesScene {
  double step = 1.0 / 60.0;
  double duration = 10.0;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  std::vector<std::string> files;  // CSV files that were read
  SceneOutputs outputs;
};

// Errors (kContent) with file, line and key; for a collider that moves or comes from a file.
Result<TetScene> parse_tets_scene(std::string_view text, const std::string& path);

// A scene of [[bodies]] of which some are of kind "tets" or "cloth": the others, and those, with
// the step and gravity of the scene.
struct MixedFile {
  SceneFile file;
  std::vector<TetSceneBody> tets;
  std::vector<ClothSceneBody> cloths;

  bool has_guests() const { return !tets.empty() || !cloths.empty(); }
  // Sets the step of all, s.
  void set_guest_step(double step);
};

// Errors: those of parse_world(); kContent with file, line and key for a body of tetrahedra or a
// cloth, and for several cloths that nothing allows to pass through each other.
Result<MixedFile> parse_mixed(std::string_view text, const std::string& path);
// The same of a table that has been parsed.
Result<MixedFile> read_mixed(const toml::table& table, const std::string& path);

// Reads the bodies of kind "cloth" of a scene whose others are read. Errors as for parse_mixed().
Status read_cloth_bodies(const toml::table& table, MixedFile& mixed);

}  // namespace tremolo
