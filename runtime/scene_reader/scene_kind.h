// The kind of a scene file, which determines its reader.
#pragma once

#include <string>
#include <string_view>

#include "common/result.h"

namespace tremolo {

// kBodies: one table a body, each by itself. kWorld: [[bodies]] (scene_reader.h). kTets: [[bodies]]
// of kind "tets" (tets_reader.h). kCloth: [[cloths]] (cloth_reader.h).
enum class SceneKind { kBodies, kWorld, kTets, kCloth };

// Errors (kContent): no TOML, with the line; kinds that do not meet in one scene.
Result<SceneKind> scene_kind(std::string_view text, const std::string& path);

}  // namespace tremolo
