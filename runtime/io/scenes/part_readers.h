// Readers of the parts of a scene file: motions, contact and colliders, bones.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <toml++/toml.h>

#include "common/result.h"
#include "runtime/io/scenes/scene_reader.h"
#include "runtime/io/scenes/toml_keys.h"
#include "runtime/math/motion.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// As parse_world(), of a table that has been parsed.
Result<SceneFile> read_scene(const toml::table& table, const std::string& path, OtherKinds others);

// Reads position and quaternion, or turn, of a table. The quaternion is normalised.
Pose read_pose(TomlKeys& keys);

// Reads a part of a motion. path: of the scene. what: its name in errors. files: CSV files that
// were read are added. Errors as for read_world.
Result<MotionPart> read_motion_part(const toml::table& table, const std::string& path,
                                    const std::string& what, std::vector<std::string>& files);

// Reads all parts of the key `motion` of a table. what: its name in errors. placed: the moving
// thing has a `position`, which `frame = "world"` requires.
Result<Motion> read_motion(TomlKeys& keys, const std::string& path, const std::string& what,
                           std::vector<std::string>& files, bool placed = false);

// Reads load or signal, at and force, scale. usual: the load of a table without `load`. Returns
// nothing for the load "none". files: CSV files that were read are added. Errors of a key are kept
// by `keys`; others are returned: those of the CSV file.
Result<std::vector<SceneLoad>> read_load(TomlKeys& keys, const std::string& usual,
                                         std::vector<std::string>& files);

// Reads the load of a body that is in its own table, and those of `loads`. what: the body, in
// errors.
Result<std::vector<SceneLoad>> read_loads(TomlKeys& keys, const std::string& path,
                                          const std::string& what, std::vector<std::string>& files);

// The keys of a body's contact.
void read_body_contact(TomlKeys& keys, SceneBody& body);
// Those of its law: margin, stiffness or modulus, friction, restitution.
void read_contact_law(TomlKeys& keys, ContactOptions& contact);
// The stiffness or the modulus alone.
void read_contact_stiffness(TomlKeys& keys, ContactOptions& contact);

// number: of the table among its kind, from 1, for errors. path: of the scene. files: CSV files
// that were read are added. Errors as read_world.
Result<SceneCollider> read_collider(const toml::table& table, std::size_t number,
                                    const std::string& path, std::vector<std::string>& files);
Result<SceneHand> read_hand(const toml::table& table, std::size_t number, const std::string& path,
                            std::vector<std::string>& files);
Result<SceneJoint> read_joint(const toml::table& table, std::size_t number,
                              const std::string& path);

// The bones of a body in a scene file (docs/reference.md, "Scenes"). Reads `bones`, `bone-blend`
// and `bone-weights` into the body; appends the CSV files that were read to `files`. what: the
// body, in errors. Errors of a key are kept by `keys`; others are returned: kSystem for a file that
// cannot be read, kContent with file, line or row, and key or bone.
Status read_bones(TomlKeys& keys, const std::string& path, const std::string& what,
                  std::vector<std::string>& files, SceneBody& body);

}  // namespace tremolo
