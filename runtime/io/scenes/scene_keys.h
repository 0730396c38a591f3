// Keys that scenes of bodies and scenes of cloths have in common.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/damping_ratios.h"
#include "common/result.h"
#include "runtime/io/scenes/toml_keys.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// The output files of a run of the scene, and the saved world that it starts from.
struct SceneOutputs {
  std::string out;                     // folder; empty: no files
  int every = 1;                       // steps per CSV row
  int surfaces = 0;                    // files per body, evenly spaced in time
  std::string surface_format = "ply";  // ply, obj or inc
  bool plot = false;
  std::string save;     // file of the world at the end; empty: none
  std::string restore;  // file of the world at the start; empty: none
  std::string wav;      // sound file; empty: none
  std::string listen;   // of --listen: [BODY:]VERTEX or [BODY:]SELECTOR
  int sound_steps = 1;  // steps per sample of the sound; 0: as many as its modes need
};

// out, every, surfaces and surface-format alone.
void read_surface_outputs(TomlKeys& keys, SceneOutputs& outputs);
void read_outputs(TomlKeys& keys, SceneOutputs& outputs);

// damping-ratio in place of alpha and beta (common/damping_ratios.h); nullopt: no such key, or an
// error, which `keys` has.
std::optional<DampingRatios> read_damping_ratio(TomlKeys& keys);

// A name becomes that of a folder or a file.
bool is_folder_name(const std::string& name);
// Reads the key `name`, whose value becomes that of a folder.
void read_folder_name(TomlKeys& keys, std::string& name);
// "KIND 'NAME'", or "KIND NUMBER" if the table has no name, for errors.
std::string told_name(const toml::table& table, const char* kind, std::size_t number);

// One value, rows t, x, y, z, or a CSV file of these. path: of the scene. files: CSV files that
// were read are added. Errors as read_world.
Status read_gravity(TomlKeys& keys, const std::string& path, SceneGravity& gravity,
                    std::vector<std::string>& files);

// True if a table of [[bodies]] is of kind "tets", or "cloth".
bool is_of_tets(const toml::node& body);
bool is_of_cloth(const toml::node& body);

// kBodies: one table a body, each by itself. kWorld: [[bodies]], of which some may be of kind
// "tets" or "cloth" (scene_reader.h). kTets: [[bodies]] of kind "tets" alone, without loads,
// gravity that stays, and colliders that stand still and have no file (nodal_readers.h). kCloth:
// [[cloths]] (nodal_readers.h).
enum class SceneKind { kBodies, kWorld, kTets, kCloth };

// Errors (kContent): no TOML, with the line; kinds that do not meet in one scene.
Result<SceneKind> scene_kind(std::string_view text, const std::string& path);

}  // namespace tremolo
