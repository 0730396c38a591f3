// glTF 2.0 as assimp 5.2.5 understands it: 32-bit floats, a node for each copy of a mesh.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/result.h"
#include "formats/surface/gltf_data.h"

namespace tremolo {

// Converts the file to simpler glTF; nothing if it is simple already, or is not glTF 2.0. Integers
// in attributes and animations (KHR_mesh_quantization, and those of glTF itself) become floats,
// EXT_mesh_gpu_instancing becomes nodes, a byte-order mark is removed. glb: the file is a .glb.
// open: as for GltfData. Errors (kContent): a required extension that is not supported, with its
// name and what to do; accessors that cannot be read.
Result<std::optional<std::string>> plain_gltf(std::string_view bytes, bool glb,
                                              const GltfData::Open& open);

}  // namespace tremolo
