// `tremolo inspect` of scenes whose bodies are tetrahedra.
#pragma once

#include "runtime/scene_reader/tets_reader.h"

namespace tremolo {

// Returns the exit code; errors are those with which a run would end before its first step.
int inspect_tets_command(const TetScene& scene, bool json);

}  // namespace tremolo
