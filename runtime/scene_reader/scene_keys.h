// Keys that scenes of bodies and scenes of cloths have in common.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/scene/scene.h"
#include "runtime/scene_reader/toml_keys.h"

namespace tremolo {

// What a run of the scene writes. out: a folder; empty: nothing. every: a CSV row every so many
// steps. surfaces: so many of each body, evenly spaced in time, as ply, obj or inc. save: the file
// of the world at the end; restore: of the one at which it begins; wav: its sound; empty: none.
// listen: of --listen. sound_steps: steps a sample of it; 0: as many as its modes need.
struct SceneOutputs {
  std::string out;
  int every = 1;
  int surfaces = 0;
  std::string surface_format = "ply";
  bool plot = false;
  std::string save;
  std::string restore;
  std::string wav;
  std::string listen;
  int sound_steps = 1;
};

// out, every, surfaces and surface-format alone.
void read_surface_outputs(TomlKeys& keys, SceneOutputs& outputs);
void read_outputs(TomlKeys& keys, SceneOutputs& outputs);

// damping-ratio = "F1:Z1,F2:Z2" in place of alpha and beta (common/rayleigh.h).
void read_damping_ratio(TomlKeys& keys, double& alpha, double& beta);

// A name becomes that of a folder or a file.
bool is_folder_name(const std::string& name);

// One value, rows t, x, y, z, or a CSV file of these. path: of the scene. files: CSV files that
// were read are added. Errors as read_world.
Status read_gravity(TomlKeys& keys, const std::string& path, SceneGravity& gravity,
                    std::vector<std::string>& files);

}  // namespace tremolo
