// The bones of a body in a scene file (docs/reference.md, "Scenes").
#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/scene/scene.h"
#include "runtime/scene_reader/toml_keys.h"

namespace tremolo {

// Reads `bones`, `bone-blend` and `bone-weights` into the body; appends the CSV files that were
// read to `files`. what: the body, in errors. Errors of a key are kept by `keys`; others are
// returned: kSystem for a file that cannot be read, kContent with file, line or row, and key or
// bone.
Status read_bones(TomlKeys& keys, const std::string& path, const std::string& what,
                  std::vector<std::string>& files, SceneBody& body);

}  // namespace tremolo
