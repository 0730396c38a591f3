// `tremolo inspect` of a scene with [[cloths]].
#pragma once

#include "runtime/scene_reader/cloth_reader.h"

namespace tremolo {

// Prints the particles, springs, triangles, mass and fastest oscillation of each cloth, and the
// longest stable step of methods with a limit. json: one object on stdout. Returns the exit code;
// errors are printed on stderr.
int inspect_cloth_command(const ClothFile& file, bool json);

}  // namespace tremolo
