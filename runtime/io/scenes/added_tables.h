// What a world gets while it runs: a body, a collider, a joint or a load, each as the text of its
// table in a scene file (TOML), without a header.
//
// path: where the text would be; paths in it are relative to that. Errors as for parse_mixed().
#pragma once

#include <string>
#include <string_view>

#include "common/result.h"
#include "runtime/bodies/cloth/cloth_scene.h"
#include "runtime/io/scenes/nodal_readers.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// The step, the gravity and the wind of a scene, without cloths.
ClothScene surroundings_of(const MixedFile& scene);

// One body of any kind. around: of the world. Error also (kContent): `copies`.
Result<MixedFile> parse_added_body(std::string_view table, const std::string& path,
                                   const ClothScene& around);
Result<SceneCollider> parse_added_collider(std::string_view table, const std::string& path);
// to: kWorldName is the world, unless a body has that name.
Result<SceneJoint> parse_added_joint(std::string_view table, const std::string& path);
// Error also (kContent): the table has no load.
Result<SceneLoad> parse_added_load(std::string_view table, const std::string& path);

}  // namespace tremolo
