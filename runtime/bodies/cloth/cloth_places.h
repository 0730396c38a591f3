// Places of particles in a cloth, as texts of scene files.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/bodies/cloth/cloth_parts.h"
#include "runtime/bodies/cloth/cloth_scene.h"

namespace tremolo {

// Adds the particles of a place, by the numbers of grid points or of the file's vertices: a number;
// "near:X,Y,Z", the nearest particle at rest; of a grid "corners", "left", "right", "top",
// "bottom", "top-left" and so on. parts: of the cloth; null: a place other than near. Errors
// (kContent): a text that is no place; a grid without that number.
Status add_cloth_place(const SceneCloth& cloth, const ClothParts* parts, const std::string& place,
                       std::vector<std::size_t>& particles);

}  // namespace tremolo
