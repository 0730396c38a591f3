// glTF 2.0 as assimp 5.2.5 understands it: 32-bit floats, a node for each copy of a mesh.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/result.h"
#include "formats/surface/gltf_data.h"

namespace tremolo {

// The bytes of the file in plainer terms, or nothing where they are plain already, or are not glTF
// 2.0. Integers in attributes and animations (KHR_mesh_quantization, and what glTF itself allows)
// become floats, EXT_mesh_gpu_instancing becomes nodes, a byte-order mark goes. glb: the file is a
// .glb. open: as GltfData's. Errors (kContent): an extension that the file requires and that is not
// understood, with its name and what to do; accessors that cannot be read.
Result<std::optional<std::string>> plain_gltf(std::string_view bytes, bool glb,
                                              const GltfData::Open& open);

}  // namespace tremolo
