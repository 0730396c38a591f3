// The pins of a cloth in a scene file: words and numbers -> particles.
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/cloth/cloth_scene.h"
#include "runtime/scene_reader/toml_keys.h"

namespace tremolo {

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

}  // namespace tremolo
