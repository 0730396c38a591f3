#include "runtime/scene_reader/contact_reader.h"

#include <utility>

#include "runtime/scene_reader/motion_reader.h"
#include "runtime/scene_reader/toml_keys.h"

namespace tremolo {
namespace {

void need(TomlKeys& keys, const char* key) {
  if (!keys.has(key)) keys.fail(key, std::string("it has no `") + key + "`");
}

// A key whose value is a length of the shape.
void read_length(TomlKeys& keys, const char* key, double& length) {
  need(keys, key);
  keys.read(key, length);
}

SphereShape read_sphere(TomlKeys& keys) {
  SphereShape sphere;
  read_length(keys, "radius", sphere.radius);
  return sphere;
}

CapsuleShape read_capsule(TomlKeys& keys) {
  CapsuleShape capsule;
  read_length(keys, "radius", capsule.radius);
  read_length(keys, "half-length", capsule.half_length);
  return capsule;
}

BoxShape read_box(TomlKeys& keys) {
  BoxShape box;
  need(keys, "half-extents");
  keys.read("half-extents", box.half_extents);
  return box;
}

CylinderShape read_cylinder(TomlKeys& keys) {
  CylinderShape cylinder;
  read_length(keys, "radius", cylinder.radius);
  read_length(keys, "half-length", cylinder.half_length);
  return cylinder;
}

void read_shape(TomlKeys& keys, SceneCollider& collider) {
  const std::vector<std::string_view> kinds = {"plane", "sphere",   "capsule",
                                               "box",   "cylinder", "mesh"};
  const std::size_t kind = keys.read_word("shape", kinds, kinds.size());
  need(keys, "shape");
  if (kind == 0) collider.shape = PlaneShape{};
  if (kind == 1) collider.shape = read_sphere(keys);
  if (kind == 2) collider.shape = read_capsule(keys);
  if (kind == 3) collider.shape = read_box(keys);
  if (kind == 4) collider.shape = read_cylinder(keys);
  if (kind == 5) {
    need(keys, "file");
    keys.read_path("file", collider.file);
    keys.read("made-by", collider.made_by);
    return;
  }
  if (keys.good())
    if (Status s = check(collider.shape); !s) keys.fail("shape", s.error().message);
}

}  // namespace

Result<SceneCollider> read_collider(const toml::table& table, std::size_t number,
                                    const std::string& path, std::vector<std::string>& files) {
  SceneCollider collider;
  std::string what = "collider " + std::to_string(number);
  if (const auto name = table["name"].value_exact<std::string>()) what = "collider '" + *name + "'";
  TomlKeys keys(table, path, what);
  need(keys, "name");
  keys.read("name", collider.name);
  read_shape(keys, collider);
  collider.pose = read_pose(keys);
  keys.read("friction", collider.friction);
  keys.read("restitution", collider.restitution);
  if (Status s = take(collider.motion, read_motion(keys, path, what, files)); !s) return s.error();
  if (Status s = keys.finish(); !s) return s.error();
  return collider;
}

Result<SceneHand> read_hand(const toml::table& table, std::size_t number, const std::string& path,
                            std::vector<std::string>& files) {
  SceneHand hand;
  const std::string what = "hand " + std::to_string(number);
  TomlKeys keys(table, path, what);
  for (const char* key : {"body", "at", "stiffness"}) need(keys, key);
  keys.read("body", hand.body);
  keys.read_text_or_number("at", hand.at);
  keys.read("stiffness", hand.stiffness);
  keys.read("damping", hand.damping);
  if (keys.has("position")) keys.read("position", hand.position.emplace());
  keys.read("from", hand.from);
  keys.read("until", hand.until);
  if (Status s = take(hand.motion, read_motion(keys, path, what, files)); !s) return s.error();
  if (Status s = keys.finish(); !s) return s.error();
  return hand;
}

}  // namespace tremolo
