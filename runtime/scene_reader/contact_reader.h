// The colliders, hands and joints of a scene file: tables -> SceneCollider, SceneHand, SceneJoint.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <toml++/toml.h>

#include "common/result.h"
#include "runtime/scene/scene.h"
#include "runtime/scene_reader/toml_keys.h"

namespace tremolo {

// The keys of a body's contact.
void read_body_contact(TomlKeys& keys, SceneBody& body);

// number: of the table among its kind, from 1, for errors. path: of the scene. files: CSV files
// that were read are added. Errors as read_world.
Result<SceneCollider> read_collider(const toml::table& table, std::size_t number,
                                    const std::string& path, std::vector<std::string>& files);
Result<SceneHand> read_hand(const toml::table& table, std::size_t number, const std::string& path,
                            std::vector<std::string>& files);
Result<SceneJoint> read_joint(const toml::table& table, std::size_t number,
                              const std::string& path);

}  // namespace tremolo
